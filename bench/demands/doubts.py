"""Doubts about the limits of a log's demands: where they cross."""

import numpy as np

from alloc.allocation import BoolArray, FloatArray


def crossing(N: int, low: FloatArray | None, high: FloatArray | None) -> BoolArray:
    """(N,) whether some limits (N, n) of each demand cross; nowhere without limits."""
    if low is None or high is None:
        return np.zeros(N, dtype=bool)
    crosses: BoolArray = np.any(low > high, axis=1)
    return crosses


def of_limits(log: str, crosses: BoolArray) -> str:
    """A line where limits of demands cross; empty where none do."""
    if not crosses.any():
        return ""
    return (
        f"{log}: limits cross in {np.count_nonzero(crosses):,} of {len(crosses):,} demands, first in demand"
        f" {crosses.argmax()} (counted from 0); no thrust lies within them, so no method can keep them"
    )
