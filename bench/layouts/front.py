"""The layouts that no other one beats in everything: a Pareto front, kept while shards pass by."""

from typing import TYPE_CHECKING

import numpy as np

from alloc.allocation import BoolArray, FloatArray

if TYPE_CHECKING:
    import pyarrow as pa

MORE, LESS = ("authority", "authority_after_one"), ("worst_case_steps", "thrusters")
"""What counts: authority, whole and after the worst failure, and what that costs: steps and thrusters."""


def losses(table: "pa.Table") -> FloatArray:
    """(M, 4) what counts of each layout, the less the better; a cost that is not known counts as infinite."""
    more = [-table[name].to_numpy() for name in MORE]
    less = [np.nan_to_num(table[name].to_numpy().astype(float), nan=np.inf) for name in LESS]
    return np.array([*more, *less]).T


def unbeaten(points: FloatArray) -> BoolArray:
    """Which points (M, p) no other one equals or beats in all coordinates; the first of equal ones counts.

    Sorted, a point can only be beaten by one before it.
    """
    order = np.lexsort(points.T[::-1])
    kept = np.zeros(len(points), dtype=bool)
    front = np.empty((0, points.shape[1]))
    for i in order:
        if not (front <= points[i]).all(axis=1).any():
            front = np.vstack([front, points[i]])
            kept[i] = True
    return kept


def merged(front: "pa.Table | None", shard: "pa.Table") -> "pa.Table":
    """The front of a front and a shard's rows."""
    import pyarrow as pa

    points = losses(shard)
    if front is not None:
        beaten = np.zeros(len(points), dtype=bool)
        for better in losses(front):
            beaten |= (better <= points).all(axis=1)
        shard = pa.concat_tables([front, shard.filter(pa.array(~beaten))])
        points = losses(shard)
    return shard.filter(pa.array(unbeaten(points)))


def spread(front: "pa.Table", count: int) -> "pa.Table":
    """At most ``count`` layouts of a front, evenly along their authority, the most authority first."""
    order = np.lexsort(
        [front["layout"].to_numpy(), front["round"].to_numpy(), -front["authority"].to_numpy()]
    )
    places = np.unique(np.linspace(0, len(order) - 1, min(count, len(order))).round().astype(int))
    return front.take(order[places])
