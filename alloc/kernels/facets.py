"""Facets of the attainable set for generated C, each a weighted sum over thrusters."""

from dataclasses import dataclass

import numpy as np

from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.errors import NotApplicable
from alloc.program import Expression
from alloc.program.sums import Terms, snapped, summed
from alloc.reach.edge import edge
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import NOTHING

FACETS_LIMIT = 300
"""Most pairs of facets; each is written out and takes flash."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FacetPairs:
    """Pairs of opposite facets, each with the normal of one of them.

    Attributes
    ----------
    normals : (M, k) times ``scale`` [-]
    scale : (k,) the vehicle's ``wrench_scale`` [N, N m]
    push : (M, n) step along a normal per newton of each thruster, the largest of a row 1 [-]
    parts : indices of pairs, by parts that share no thruster
    """

    normals: FloatArray
    scale: FloatArray
    push: FloatArray
    parts: list[IndexArray]

    def crossed_by(self, D: FloatArray) -> list[int]:
        """Pairs that a level's step D (tau - w) can approach, part by part."""
        along = np.abs(self.normals @ (D * (self.scale / self.scale[:, None])))
        return [m for part in self.parts for m in part.tolist() if along[m].max() > NOTHING]

    def part_index(self, m: int) -> int:
        """Index of a pair's part."""
        return next(j for j, part in enumerate(self.parts) if m in part)

    def thrusters(self, part: int) -> list[int]:
        """Thrusters that push along facets of a part."""
        return np.flatnonzero(self.push[self.parts[part]].any(axis=0)).tolist()


def facet_pairs(vehicle: Vehicle) -> FacetPairs:
    """Facets of a vehicle; raises NotApplicable for too many of them."""
    found = edge(vehicle)
    if len(found.normals) > FACETS_LIMIT:
        raise NotApplicable(
            f"generated C: each facet is written out, here {len(found.normals)} pairs, more than "
            f"{FACETS_LIMIT}; use the method in Python"
        )
    # With the largest push of a row 1, the margin of a facet is a plain sum on many vehicles.
    push = snapped(found.push / np.abs(found.push).max(axis=1)[:, None])
    return FacetPairs(
        normals=found.normals * found.scale,
        scale=found.scale,
        push=push,
        parts=components(push != 0),
    )


def components(linked: BoolArray) -> list[IndexArray]:
    """Rows of (M, n) by parts that share no column."""
    near = linked @ linked.T
    for _ in range(linked.shape[1].bit_length()):  # each product doubles the length of the paths
        near = near @ near
    return [np.flatnonzero(row) for row in np.unique(near, axis=0)[::-1]]


def group_alike(pairs: list[int], along: FloatArray) -> list[list[tuple[int, bool]]]:
    """Group pairs of facets with equal rows of ``along`` (M, k), up to the sign.

    Each pair comes with True if its sign differs from that of its group's first.
    """
    groups: dict[tuple[float, ...], list[tuple[int, bool]]] = {}
    for m, row in zip(pairs, snapped(along) if along.size else along, strict=True):
        turned = bool(row[np.flatnonzero(row)[:1]].sum() < 0)
        groups.setdefault(tuple((-row if turned else row).tolist()), []).append((m, turned))
    return [[(m, turned != group[0][1]) for m, turned in group] for group in groups.values()]


def steps_along(
    push: FloatArray, steps: dict[int, Expression], products: dict[int, Terms], name: str
) -> list[Terms]:
    """Terms of push d, the length of a step d along each normal.

    They are sums of the ``steps`` of thrusters or, where each step has products, of these products,
    whichever is shorter.
    """
    moved = list(steps)
    of_steps = summed(push[:, moved], list(steps.values()), f"a{name}")
    used = [i for i in moved if push[:, i].any()]
    if not all(products[i] for i in used):
        return of_steps.rows
    values = list(dict.fromkeys(value for i in used for _, value in products[i]))
    spread = np.zeros((push.shape[1], len(values)))
    for i in used:
        for minus, value in products[i]:
            # A step has a product twice where a failure merged two axes.
            spread[i, values.index(value)] += -1.0 if minus else 1.0
    of_products = summed(push @ spread, values, f"go{name}")
    return of_steps.rows if of_steps.terms <= of_products.terms else of_products.rows
