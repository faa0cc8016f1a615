"""The factor by which thrusts exceed their limits."""

import numpy as np

from alloc.allocation import FloatArray

LEAST = 1e-5
"""A limit nearer to zero than this share of the largest one counts as that far away. Rounding asks a thruster
that can't reverse (f_min = 0) for -1e-15 N, or in single precision for -1e-6 N, which must not stop all the
others; and the nearer, the more of the others' thrusts a rounding error decides."""


def load(f: list[float], limits: list[tuple[float, float]], least: float) -> float:
    """The largest f_i over the limit on its side of zero, at least 1 [-].

    Parameters
    ----------
    f : thrusts [N]
    limits : (f_min, f_max) of each [N]
    least : how far from zero each limit counts as at least [N]
    """
    most = 1.0
    for x, (low, high) in zip(f, limits, strict=True):
        most = max(most, x / (max(high, least) if x > 0.0 else min(low, -least)))
    return most


def loads(F: FloatArray, low: FloatArray, high: FloatArray, least: float) -> FloatArray:
    """(N,) the same of thrusts F (N, n) within limits low and high (N, n)."""
    far = np.where(F > 0.0, high.clip(min=least), low.clip(max=-least))
    most: FloatArray = (F / far).max(axis=1).clip(min=1.0)
    return most
