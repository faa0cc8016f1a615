"""Equations to verdicts: what answers are worth, what they lose, what a vehicle can do."""
