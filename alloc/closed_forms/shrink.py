"""Generalized inverse, then all thrusts scaled by one factor until they fit: keeps the wrench's direction."""

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.vehicle import Vehicle

NAME = "shrink"

ROUNDING = 1e-9
"""An excess below this share of the largest limit is cut, not shrunk: a thruster that can't reverse
(f_min = 0) and is asked for -1e-15 N must not stop all the others."""


def shrink(vehicle: Vehicle) -> Saturating:
    """Prepare f = s T* tau, s the largest factor in [0, 1] that brings every excess to its limit.

    Shrinking helps against a limit on the far side of zero only. A thrust that is too small for a
    thruster that must always push (f_min > 0) is raised to it, which turns the wrench; and a thruster
    that can't reverse but is asked to leaves s = 0.
    """
    slack = ROUNDING * vehicle.f_scale

    def one(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        s = 1.0
        for x, (low, high) in zip(f, limits.pairs, strict=True):
            if x > high + slack and x > 0.0:
                s = min(s, max(high, 0.0) / x)
            elif x < low - slack and x < 0.0:
                s = min(s, min(low, 0.0) / x)
        return [s * x for x in f], 1

    def each(taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        far = np.where(F > 0.0, high.clip(min=0.0), low.clip(max=0.0))
        beyond = np.where(F > 0.0, F - high, low - F) > slack
        beyond &= F != 0.0
        s = np.where(beyond, far / np.where(beyond, F, 1.0), 1.0).min(axis=1)
        shrunk: FloatArray = s[:, None] * F
        return shrunk

    return Saturating(vehicle, NAME, one, each)
