"""``Region.nearest`` for many demands at once, one in each column: the same steps under masks."""

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.nullspace.region import Region


def nearest_many(region: Region, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Shortest z (d, N) with lower <= A z <= upper, both (m, N), and (N,) whether a column has such a z."""
    count = lower.shape[1]
    feasible = np.ones(count, dtype=bool)
    for row in region.checks:
        feasible &= (lower[row] <= region.tolerance) & (upper[row] >= -region.tolerance)
    lo = np.empty((len(region.slabs), count))
    hi = np.empty_like(lo)
    for i, slab in enumerate(region.slabs):
        sides = [
            (lower[row] * scale, upper[row] * scale)[:: 1 if scale > 0 else -1] for row, scale in slab.members
        ]
        lo[i] = np.max([low for low, _ in sides], axis=0)
        hi[i] = np.min([high for _, high in sides], axis=0)
        feasible &= lo[i] - hi[i] <= slab.slack
        touching = lo[i] > hi[i]
        lo[i, touching] = hi[i, touching] = 0.5 * (lo[i, touching] + hi[i, touching])
    z = np.zeros((region.d, count))
    for i, slab in enumerate(region.slabs):
        s = np.asarray(slab.normal) @ z
        out = np.flatnonzero(feasible & ((s < lo[i]) | (s > hi[i])))
        if not out.size:
            continue
        b = np.where(s[out] < lo[i, out], lo[i, out], hi[i, out])
        z[:, out] = np.multiply.outer(slab.base, b)
        if slab.plane is not None:
            moved = np.multiply.outer(slab.shift, b)
            y, feasible[out] = nearest_many(slab.plane, lo[:i, out] - moved, hi[:i, out] - moved)
            z[:, out] += np.asarray(slab.along) @ y
    return z, feasible
