"""Random boats whose thrusters turn, in discs and sectors, beside fixed ones."""

import numpy as np

from alloc import Vehicle
from alloc.vehicle.azimuth import Azimuth, polygon_corners

AXES = ("surge", "sway", "yaw")


def boat(rng: np.random.Generator, azimuths: int, fixed: int) -> Vehicle:
    """A vehicle in the plane with that many thrusters that turn, in discs and sectors, beside fixed ones.

    The first is in a disc or a sector of more than a quarter, so that all axes are pushed.
    """
    columns, turning, weights = list[tuple[float, ...]](), list[Azimuth](), list[float]()
    places = rng.uniform(-5.0, 5.0, (azimuths + fixed, 2))
    for x, y in places[:azimuths]:
        sides = int(rng.integers(3, 21))
        start = rng.uniform(-180.0, 180.0)
        sector = (-180.0, 180.0) if rng.random() < 0.6 else (start, start + rng.uniform(40.0, 180.0))
        turning.append(Azimuth(len(columns), polygon_corners(rng.uniform(20.0, 200.0), sector, sides)))
        columns += [(1.0, 0.0, -y), (0.0, 1.0, x)]
        weights += [rng.uniform(0.5, 2.0)] * 2
    for x, y in places[azimuths:]:
        angle = rng.uniform(-np.pi, np.pi)
        columns.append((np.cos(angle), np.sin(angle), x * np.sin(angle) - y * np.cos(angle)))
        weights.append(rng.uniform(0.5, 2.0))
    n = len(columns)
    return Vehicle(
        name=f"boat-{azimuths}-{fixed}",
        dof=AXES,
        T=np.array(columns).T,
        H=np.diag(weights),
        f_min=-rng.uniform(5.0, 100.0, n),
        f_max=rng.uniform(5.0, 100.0, n),
        readiness=np.ones(n),
        slack_weights=np.ones(3),
        azimuths=tuple(turning),
        weak_limit=0.0,
    )


def boats(count: int, seed: int = 1, most: int = 4) -> list[Vehicle]:
    """Random boats with 1 to ``most`` azimuths and up to three fixed thrusters, all of rank 3."""
    rng, made = np.random.default_rng(seed), list[Vehicle]()
    while len(made) < count:
        azimuths = 1 + len(made) % most
        fixed = int(rng.integers(1 if azimuths == 1 else 0, 4))
        if (vehicle := boat(rng, azimuths, fixed)).rank == 3:
            made.append(vehicle)
    return made
