"""Reach of a vehicle: attainable set, distance of demands from its edge, volumes."""
