"""Vehicles whose axes arms of millimetres to centimetres couple, with a direction lost to a failure."""

import numpy as np

from alloc import Vehicle
from alloc.vehicle.geometry import DOF, pose_matrix

AT = [(0.31, 0.22), (0.31, -0.22), (-0.33, 0.22), (-0.33, -0.22), (0.28, 0.0), (-0.15, 0.26), (-0.15, -0.26)]
ALONG = [(0.8, -0.6, 0), (0.8, 0.6, 0), (-0.8, -0.6, 0), (-0.8, 0.6, 0), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
LEVELS = (("heave", "roll", "pitch"), ("yaw",), ("surge", "sway"))
DEAD = 4
"""The thruster at the bow that pushes up: without it there is no heave without pitch."""


def coupled(rng: np.random.Generator) -> Vehicle:
    """Four thrusters along the deck, two of three up, levels in any order, centre of mass a little off."""
    beside = 10.0 ** rng.uniform(-3, -1, 3) * rng.choice([-1.0, 1.0], 3)
    T = pose_matrix(np.column_stack([AT, np.zeros(7)]), np.array(ALONG, dtype=float), beside)
    return Vehicle(
        name="coupled",
        dof=DOF,
        T=np.ascontiguousarray(T),
        H=np.eye(7),
        f_min=np.full(7, -39.0),
        f_max=np.full(7, 51.0),
        readiness=np.ones(7),
        slack_weights=np.full(6, 2000.0),
        priority=tuple(LEVELS[i] for i in rng.permutation(len(LEVELS)).tolist()),
        groups=(("heave", "roll", "pitch"), ("surge", "sway", "yaw")),
    ).with_fault(DEAD)
