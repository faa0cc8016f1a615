"""Generalized inverse, then all thrusts scaled by one factor until they fit: keeps the wrench's direction."""

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.vehicle import Vehicle

NAME = "shrink"

LEAST = 1e-5
"""A limit nearer to zero than this share of the largest one counts as that far away. Rounding asks a thruster
that can't reverse (f_min = 0) for -1e-15 N, or in single precision for -1e-6 N, which must not stop all the
others; and the nearer, the more of the others' thrusts a rounding error decides."""


def shrink(vehicle: Vehicle) -> Saturating:
    """Prepare f = s T* tau, s the largest factor in [0, 1] that brings every excess to its limit.

    s = 1 / max(1, x_i / far_i) with far_i the limit on x_i's side of zero, at least LEAST away, so that s is
    continuous in tau. Shrinking helps against a limit on the far side of zero only. A thrust that is too
    small for a thruster that must always push (f_min > 0) is raised to it, which turns the wrench; and a
    thruster that can't reverse but is asked to leaves next to nothing of s.
    """
    least = LEAST * vehicle.f_scale

    def one(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        load = 1.0
        for x, (low, high) in zip(f, limits.pairs, strict=True):
            load = max(load, x / (max(high, least) if x > 0.0 else min(low, -least)))
        s = 1.0 / load
        return [s * x for x in f], 1

    def each(taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        far = np.where(F > 0.0, high.clip(min=least), low.clip(max=-least))
        s = 1.0 / (F / far).max(axis=1).clip(min=1.0)
        shrunk: FloatArray = s[:, None] * F
        return shrunk

    return Saturating(vehicle, NAME, one, each)
