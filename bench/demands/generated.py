"""Generates vehicles for studies; ``thrustbench run --study`` measures methods on them."""

import numpy as np

from alloc import Vehicle
from alloc.vehicle.geometry import DOF

SIZES = {3: (4, 6, 8, 12, 16, 24, 32, 48, 64), 6: (8, 12, 16, 24, 32, 48, 64)}
"""Numbers of thrusters of the growth study, for each number of controlled degrees of freedom."""
AXES = {3: (0, 1, 5), 6: (0, 1, 2, 3, 4, 5)}
"""The controlled rows of a 6-DOF wrench, for each number of controlled degrees of freedom."""
RADIUS_M, LIMIT_N = 0.5, 50.0
"""About the size [m] and the thrust [N] of a small inspection vehicle."""


def growth_vehicles() -> list[Vehicle]:
    """Every vehicle of the growth study, which shows how time and memory of a method grow with n."""
    return [growth_vehicle(k, n) for k, sizes in SIZES.items() for n in sizes]


def growth_vehicle(k: int, n: int) -> Vehicle:
    """The vehicle of k degrees of freedom, 3 or 6, and n thrusters.

    Thrusters sit evenly on a circle (k = 3) or a sphere (k = 6) and push in seeded random
    directions, so that no two sizes share a special symmetry.
    """
    rng = np.random.default_rng([k, n])
    turn = np.arange(n) * np.pi * (3 - np.sqrt(5))  # the golden angle spreads points evenly on a sphere
    if k == 3:
        turn, height = 2 * np.pi * np.arange(n) / n, np.zeros(n)
    else:
        height = (2 * np.arange(n) + 1) / n - 1
    ring = np.sqrt(1 - height**2)
    positions = RADIUS_M * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    directions = rng.standard_normal((n, 3)) * ([1.0, 1.0, 0.0] if k == 3 else [1.0, 1.0, 1.0])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rows = np.vstack([directions.T, np.cross(positions, directions).T])
    return Vehicle(
        name=f"growth-k{k}-n{n}",
        dof=tuple(DOF[axis] for axis in AXES[k]),
        T=rows[list(AXES[k])],
        H=np.eye(n),
        f_min=np.full(n, -LIMIT_N),
        f_max=np.full(n, LIMIT_N),
        readiness=np.ones(n),
        slack_weights=np.full(k, 2000.0),
        source="generated for the growth study",
    )


STUDIES = {"growth": growth_vehicles}
"""The vehicles of each study, by its name."""
