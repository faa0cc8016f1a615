"""The second half-minute under way: ``mission`` after the thruster that costs most has failed."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.reach.volumes import worst_fault
from bench.demands.mission import HALF, RATE_HZ, STEPS, fly
from bench.demands.strong import strong_vehicle

__all__ = ["COUNT", "RATE_HZ", "SEED_NAME", "answering", "demands", "start"]

COUNT = HALF
SEED_NAME = "mission"
"""It shares the seed of ``mission``, because both are one flight, cut at the failure."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n consecutive demands (n, k) [N, N m] at RATE_HZ; fewer than all start at the first waypoint then."""
    taus = fly(vehicle, answering(vehicle), rng).taus[HALF:]
    first = start(vehicle, taus, n)
    return taus[first : first + n]


def start(vehicle: Vehicle, taus: FloatArray, n: int) -> int:
    """First of the n demands, of all ``taus``, that are timed: that of the first waypoint, if it can be."""
    first = next(step for step in STEPS if step >= HALF) - HALF
    return min(first, HALF - min(n, HALF))


def answering(vehicle: Vehicle) -> Vehicle:
    """The vehicle after the single fault that costs most volume, of those that keep the rank if any does.

    Where rank is lost, no demand of an autopilot that does not know of the loss is attainable, and methods
    can't be told apart.
    """
    return vehicle.with_fault(worst_fault(strong_vehicle(vehicle), keep_rank=True))
