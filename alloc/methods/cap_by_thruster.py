"""Least effort within limits at which each of n thrusters draws at most its n-th part of the cap."""

import numpy as np

from alloc.allocation import Allocation, FloatArray
from alloc.formulations.cap_rule import FORMULATION as ANSWERED
from alloc.nullspace.cap_rule import CapRuled, Scaled
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.current import Draw
from alloc.vehicle.limits import Interval

FORMULATION = ANSWERED.name
NAMED_ONLY = True  # without a cap it is scaled
HALVINGS = 60
"""Halvings of a limit: they leave less than its last bit."""


def build(vehicle: Vehicle) -> CapRuled:
    """Prepare ``scaled`` within limits that hold each working thruster to its part of the cap."""
    count = len(vehicle.working)
    known: tuple[object, Draw, Interval] | None = None  # of the last call: most calls have the same limits

    def by_thruster(scaled: Scaled, tau: FloatArray, limits: Interval, draw: Draw, cap: float) -> Allocation:
        nonlocal known
        key = (limits[0].tolist(), limits[1].tolist(), cap)
        last = known
        if last is None or last[0] != key or last[1] is not draw:
            last = known = key, draw, limits_at_current(draw, limits, cap / count)
        return scaled(tau, *last[2])

    return CapRuled(vehicle, by_thruster)


def limits_at_current(draw: Draw, limits: Interval, amps: float) -> Interval:
    """Limits (n,) at which each thruster draws so many amperes, or its own where these draw less [N].

    Where limits exclude rest, as near to it as they allow.
    """
    rest, nearer = start(*limits), []
    for side in limits:
        least, most = np.zeros(len(side)), np.ones(len(side))
        for _ in range(HALVINGS):
            middle = (least + most) / 2
            fits = draw.amps(rest + middle * (side - rest)) <= amps
            least, most = np.where(fits, middle, least), np.where(fits, most, middle)
        nearer.append(rest + least * (side - rest))
    return nearer[0], nearer[1]
