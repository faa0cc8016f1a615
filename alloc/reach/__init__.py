"""What a vehicle can do: the attainable set, how far a demand lies from its edge, and volumes."""
