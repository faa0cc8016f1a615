"""The shares that answers say of a demand's levels, and whether their thrusts deliver them."""

from collections.abc import Sequence

import numpy as np

from alloc import NotApplicable
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray, IndexArray
from alloc.formulations import find_formulation
from bench.demands import DemandSet


def misstated(
    demands: DemandSet,
    demand: IndexArray,
    shares: Sequence[Sequence[float]],
    f: FloatArray,
    formulation: str,
    tolerance: float,
    wrench_tolerance: float = WRENCH_TOLERANCE,
) -> BoolArray:
    """Which of M answers say shares that their thrusts f (M, n) [N] do not deliver.

    By the formulation's way, the shares of an answer make a wrench of its demand, ``demands.taus[demand]``.
    It may differ from T P f by ``wrench_tolerance``, and by as much as thrusts ``tolerance`` apart, relative
    to the largest limit, may make. An answer that says nothing misstates nothing. Of a formulation without
    a way it is known only that shares lie in 0 … 1.
    """
    wrong = np.array([any(not 0.0 <= part <= 1.0 for part in share) for share in shares], dtype=bool)
    said = np.flatnonzero([len(share) > 0 for share in shares])
    vehicle, find_way = demands.vehicle, find_formulation(formulation).way
    if find_way is None or not said.size:
        return wrong
    try:
        way = find_way(vehicle)
    except NotApplicable:
        return wrong
    wrong[said] |= [len(shares[i]) != len(way.keep) for i in said.tolist()]
    rows = said[~wrong[said]]
    taken = np.array([shares[i] for i in rows.tolist()]).reshape(len(rows), len(way.keep))
    low, high = (
        np.broadcast_to(side, (len(demands.taus), vehicle.n))[demand[rows]] for side in demands.limits
    )
    begin = way.departure(low, np.maximum(low, high))
    missed = f[rows] @ vehicle.TP.T - way.delivered(demands.taus[demand[rows]], begin, taken)
    off = np.abs(missed / vehicle.wrench_scale).max(axis=1, initial=0.0)
    wrong[rows] = ~(off <= wrench_tolerance + vehicle.n * tolerance)
    return wrong


def by_level(shares: Sequence[Sequence[float]], q: float) -> list[float]:
    """Quantile ``q`` of what was delivered of each level, over the answers that say it; empty without any."""
    said = [share for share in shares if len(share) > 0 and np.isfinite(share).all()]
    if len({len(share) for share in said}) != 1:  # a method of one's own may say anything
        return []
    levels: list[float] = np.quantile(said, q, axis=0).tolist()
    return levels
