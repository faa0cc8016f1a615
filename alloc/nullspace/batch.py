"""``Region.nearest`` for many demands at once, one in each column: the same steps under masks."""

import numpy as np

from alloc.allocation import FloatArray
from alloc.nullspace.region import Region


def nearest_many(region: Region, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shortest z (d, N) with lower <= A z <= upper, both (m, N), and the excess (N,) over them.

    The excess is in units of what counts as touching; where it is above 1, a column has no such z.
    """
    count = lower.shape[1]
    excess = np.zeros(count)
    for row in region.checks:
        excess = np.maximum(excess, np.maximum(lower[row], -upper[row]) / region.tolerance)
    lo = np.empty((len(region.slabs), count))
    hi = np.empty_like(lo)
    for i, slab in enumerate(region.slabs):
        lo[i], hi[i] = -np.inf, np.inf
        for alike in slab.members:
            sides = [
                (lower[row] * scale, upper[row] * scale)[:: 1 if scale > 0 else -1]
                for row, scale in alike.rows
            ]
            low, high = np.max([low for low, _ in sides], axis=0), np.min([high for _, high in sides], axis=0)
            apart = np.maximum(low - high, np.maximum(low - hi[i], lo[i] - high))
            excess = np.maximum(excess, apart / alike.slack)
            touching = low > high
            low[touching] = high[touching] = 0.5 * (low[touching] + high[touching])
            lo[i], hi[i] = low.clip(lo[i], hi[i]), high.clip(lo[i], hi[i])
    z = np.zeros((region.d, count))
    for i, slab in enumerate(region.slabs):
        s = np.asarray(slab.normal) @ z
        out = np.flatnonzero((excess <= 1.0) & ((s < lo[i]) | (s > hi[i])))
        if not out.size:
            continue
        b = np.where(s[out] < lo[i, out], lo[i, out], hi[i, out])
        z[:, out] = np.multiply.outer(slab.base, b)
        if slab.plane is not None:
            moved = np.multiply.outer(slab.shift, b)
            y, beyond = nearest_many(slab.plane, lo[:i, out] - moved, hi[:i, out] - moved)
            excess[out] = np.maximum(excess[out], beyond)
            z[:, out] += np.asarray(slab.along) @ y
    return z, excess
