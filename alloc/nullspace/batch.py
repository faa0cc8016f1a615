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
        sides = [
            (lower[row] * scale, upper[row] * scale)[:: 1 if scale > 0 else -1] for row, scale in slab.members
        ]
        lo[i] = np.max([low for low, _ in sides], axis=0)
        hi[i] = np.min([high for _, high in sides], axis=0)
        excess = np.maximum(excess, (lo[i] - hi[i]) / slab.slack)
        touching = lo[i] > hi[i]
        lo[i, touching] = hi[i, touching] = 0.5 * (lo[i, touching] + hi[i, touching])
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
