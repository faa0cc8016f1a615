"""Demands whose limits jump at every call: narrow, one-sided, without width, excluding zero, crossing."""

import numpy as np

from alloc import Vehicle
from bench.demands import CallDemands
from bench.demands.strong import strong_vehicle

STILL = 0.1
"""Share of thrusters that have only one thrust left, as one that is stuck."""
ONE_SIDED = 0.2
"""Share of thrusters that can't reverse, or only reverse."""
CROSSING = 0.05
"""Share of demands in which one thruster's limits contradict each other."""
SIZES = (0.2, 1.5)
"""Range of factors on a wrench that the limits allow: nearly nothing to half as much again."""


def limited_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> CallDemands:
    """n demands with random limits inside the vehicle's, nothing carried from one to the next."""
    ends = rng.uniform(vehicle.f_min, vehicle.f_max, (2, n, vehicle.n))
    lows, highs = ends.min(axis=0), ends.max(axis=0)
    kind = rng.random(lows.shape)
    lows = np.where(kind < ONE_SIDED, np.minimum(highs, np.maximum(lows, 0.0)), lows)
    lows = np.where(kind > 1 - STILL, highs, lows)
    thrusts = rng.uniform(lows, highs)
    rows = np.flatnonzero(rng.random(n) < CROSSING)
    thrusters = rng.integers(vehicle.n, size=len(rows))
    width = vehicle.f_max[thrusters] - vehicle.f_min[thrusters]
    lows[rows, thrusters] = highs[rows, thrusters] + rng.uniform(0.01, 0.5, len(rows)) * width
    pushed = strong_vehicle(vehicle).TP.T
    return CallDemands(rng.uniform(*SIZES, n)[:, None] * thrusts @ pushed, lows, highs)
