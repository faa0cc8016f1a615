"""The first half-minute under way: stationkeeping and waypoints in a current, with all thrusters working."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.mission import HALF, RATE_HZ, interesting_start, under_way

__all__ = ["COUNT", "RATE_HZ", "SEED_NAME", "demands", "start"]

COUNT = HALF
SEED_NAME = "mission"


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n consecutive demands (n, k) [N, N m] at RATE_HZ; fewer than all start at the first waypoint."""
    return under_way(vehicle, rng, n)


def start(vehicle: Vehicle, taus: FloatArray, n: int) -> int:
    """First of the n demands, of all ``taus``, that are timed."""
    return interesting_start(vehicle, taus, n)
