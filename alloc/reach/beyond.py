"""Whether a demand lies beyond what the thrusters can do, shown by one direction."""

from collections.abc import Callable
from math import comb

import numpy as np

from alloc.allocation import FloatArray
from alloc.reach.zonotope import facets
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import NOTHING

ENUMERATED = 5_000
"""Most candidate facets that are enumerated when an allocator is built, within a tenth of a second."""

Beyond = Callable[[FloatArray, FloatArray, FloatArray], bool]
"""A function of a demand (k,) [N, N m] and the limits f_min and f_max (n,) of a call [N]: whether it is
proven that no thrusts inside these limits push that demand."""


def beyond(vehicle: Vehicle) -> Beyond:
    """Prepare the proof that a demand is infeasible, from T P, the demand and the limits of the call alone.

    Whatever the direction c, no thrusts inside the limits push further along it than

        h(c) = sum over thrusters of max(c'T_i f_min_i, c'T_i f_max_i)

    so c'tau > h(c) proves that tau is infeasible, also for a c that is rounded. Every infeasible demand has
    such a c: the normal of a facet, or the step to the demand from the nearest wrench that is attainable,
    which is taken where the facets are too many. A demand beyond the edge by rounding only is not proven so.
    """
    scaled = vehicle.TP / vehicle.wrench_scale[:, None]
    lengths = np.linalg.norm(scaled, axis=0)
    normals: FloatArray | None = None
    if comb(len(vehicle.working), max(vehicle.rank - 1, 0)) <= ENUMERATED:
        # Facets that the set has within other limits are spanned by the same subsets of thrusters.
        half = facets(vehicle, tuple(vehicle.working.tolist())).half
        normals, along_normals = np.vstack([half, -half]), np.vstack([half, -half]) @ scaled

    def proven(tau: FloatArray, f_min: FloatArray, f_max: FloatArray) -> bool:
        t = tau / vehicle.wrench_scale
        doubt = NOTHING * (np.linalg.norm(t) + lengths @ np.maximum(np.abs(f_min), np.abs(f_max)))
        if normals is None:
            c = step_to(t, scaled, f_min, f_max)
            along, wanted = c @ scaled, np.atleast_1d(c @ t)
        else:
            along, wanted = along_normals, normals @ t
        farthest = np.maximum(along * f_min, along * f_max).sum(axis=-1)
        return bool((wanted - farthest > doubt).any())

    return proven


def step_to(t: FloatArray, A: FloatArray, f_min: FloatArray, f_max: FloatArray) -> FloatArray:
    """Unit step (k,) to t from the nearest A f with f_min <= f <= f_max; zero where A f = t for such an f."""
    from scipy.optimize import lsq_linear

    free = f_min < f_max
    rest: FloatArray = t - A[:, ~free] @ f_min[~free]
    if free.any():
        unit = float(np.maximum(np.abs(f_min), np.abs(f_max)).max())
        nearest = lsq_linear(A[:, free] * unit, rest, (f_min[free] / unit, f_max[free] / unit), "bvls", 1e-15)
        rest = rest - A[:, free] @ (nearest.x * unit)
    length = float(np.linalg.norm(rest))
    return rest / length if length > 0.0 else rest
