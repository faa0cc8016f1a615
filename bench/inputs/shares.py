"""Demands in shares of what a vehicle can do, as autopilots have them: taken for newtons they are tiny."""

from pathlib import Path

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray

LITTLE = 0.1
"""The share of an axis below which a whole log in newtons seldom stays: a dive asks for more at some time."""


def like_shares(path: Path, vehicle: Vehicle, taus: FloatArray) -> str:
    """A doubt about demands (N, k) of 1 at most, by far not what the vehicle can do; empty for others."""
    largest = np.nanmax(np.abs(taus), initial=0.0)
    each = np.abs(vehicle.TP) @ np.maximum(np.abs(vehicle.f_min), np.abs(vehicle.f_max))  # all at their ends
    if not 0 < largest <= min(1.0, LITTLE * each.max()):
        return ""
    return (
        f"{path.name}: asks for {largest:.3g} at most on any axis, far below what {vehicle.name} can do; if"
        " these are shares, --scale with what 1 is on each axis [N, N m]"
    )
