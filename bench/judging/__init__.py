"""Judges answers by equations: which are wrong, what they lose, and what a vehicle can do."""
