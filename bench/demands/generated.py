"""Generated vehicles of 4 to 64 thrusters: how time and memory of each method grow with their number.

``thrustbench run --study growth`` measures them; the report shows them (``bench.report.growth``).
"""

import re

import numpy as np

from alloc import UnknownName, Vehicle, load_vehicle
from bench.harness.plan import Settings
from bench.results.rows import GENERATED

NAME = re.compile(rf"{GENERATED}k([36])-n(\d+)")
SIZES = {3: (4, 6, 8, 12, 16, 24, 32, 48, 64), 6: (8, 12, 16, 24, 32, 48, 64)}
"""Numbers of thrusters for each number of controlled degrees of freedom."""
DOF = {3: ("surge", "sway", "yaw"), 6: ("surge", "sway", "heave", "roll", "pitch", "yaw")}
RADIUS_M, LIMIT_N = 0.5, 50.0
"""About the size and the thrust of a small inspection vehicle."""
METHODS = (
    "pinv",
    "pinv@native",
    "svd",
    "clip",
    "redistribute",
    "nullspace",
    "nullspace@native",
    "qp/clarabel",
    "qp/daqp",
    "qp/osqp",
    "qp/piqp",
    "qp/proxqp",
    "qp/quadprog",
)


def settings() -> Settings:
    """What the study measures: every size, demands that need the limits, solvers at their defaults."""
    return Settings(
        vehicles=tuple(vehicle.name for vehicle in growth_vehicles()),
        demands=("active",),
        methods=METHODS,
        levels=("default",),
        repeats=1,
        n_demands=50,
    )


def vehicle_of(name: str) -> Vehicle:
    """A vehicle of the study by its name, any other as ``load_vehicle`` finds it."""
    return growth_vehicle(name) if NAME.fullmatch(name) else load_vehicle(name)


def growth_vehicles() -> list[Vehicle]:
    """Every vehicle of the study."""
    return [growth_vehicle(f"{GENERATED}k{k}-n{n}") for k, sizes in SIZES.items() for n in sizes]


def growth_vehicle(name: str) -> Vehicle:
    """The vehicle ``growth-k<k>-n<n>``; raises UnknownName.

    Thrusters sit evenly on a circle (k = 3) or a sphere (k = 6) and push in seeded random
    directions, so that no two sizes share a special symmetry.
    """
    found = NAME.fullmatch(name)
    k, n = (int(found[1]), int(found[2])) if found else (0, 0)
    if not k < n <= 64:
        raise UnknownName(f"no vehicle '{name}'; the study has {GENERATED}k3-n4 to {GENERATED}k6-n64")
    dice = np.random.default_rng([k, n])
    turn = np.arange(n) * np.pi * (3 - np.sqrt(5))  # the golden angle spreads points evenly on a sphere
    if k == 3:
        turn, height = 2 * np.pi * np.arange(n) / n, np.zeros(n)
    else:
        height = (2 * np.arange(n) + 1) / n - 1
    ring = np.sqrt(1 - height**2)
    positions = RADIUS_M * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    directions = dice.standard_normal((n, 3)) * ([1.0, 1.0, 0.0] if k == 3 else [1.0, 1.0, 1.0])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rows = np.vstack([directions.T, np.cross(positions, directions).T])
    return Vehicle(
        name=name,
        dof=DOF[k],
        T=rows[[0, 1, 5]] if k == 3 else rows,
        H=np.eye(n),
        f_min=np.full(n, -LIMIT_N),
        f_max=np.full(n, LIMIT_N),
        readiness=np.ones(n),
        slack_weights=np.full(k, 2000.0),
        source="generated for the growth study",
    )
