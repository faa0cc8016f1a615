"""What a vehicle can do: its attainable set, how far demands lie from the edge of that, and volumes."""
