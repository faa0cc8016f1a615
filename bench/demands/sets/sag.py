"""The mission while the battery empties: each call's limits are what its voltage leaves of the thrust."""

import numpy as np

from alloc import NotApplicable, Vehicle
from bench.demands import CallDemands
from bench.demands.mission import HALF, RATE_HZ, under_way

__all__ = ["COUNT", "RATE_HZ", "SEED_NAME", "limited_demands"]

COUNT = HALF
SEED_NAME = "mission"

FULL, EMPTY = 16.8, 13.0
"""Voltage of four lithium cells in series, charged, and under load shortly before they have to be [V]."""


def limited_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> CallDemands:
    """n consecutive demands of the mission while the voltage falls evenly from FULL to EMPTY.

    A dive takes hours and the mission half a minute, so the battery empties faster than at sea; each demand
    has the limits that it would have there. Raises NotApplicable for a vehicle without limits by voltage, or
    whose table does not reach as far.
    """
    table = vehicle.by_volts
    if table is None:
        raise NotApplicable(f"{vehicle.name}: has no limits by voltage; add 'volts' to its file")
    if not table.volts[0] <= EMPTY < FULL <= table.volts[-1]:
        raise NotApplicable(
            f"{vehicle.name}: its table of volts has {table.volts[0]:g} to {table.volts[-1]:g} V, not"
            f" {EMPTY:g} to {FULL:g} V"
        )
    taus = under_way(vehicle, rng, n, *vehicle.limits(volts=EMPTY))
    limits = [vehicle.limits(volts=volts) for volts in np.linspace(FULL, EMPTY, n)]
    lows, highs = map(np.array, zip(*limits, strict=True))
    return CallDemands(taus, lows, highs)
