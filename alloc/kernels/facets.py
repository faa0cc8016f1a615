"""The facets of a vehicle's attainable set as generated C looks at them: each is a sum over thrusters."""

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
"""Most pairs of facets: each is written out, and more would fill a microcontroller's flash."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FacetPairs:
    """Pairs of opposite facets, each by the normal of one of the two.

    Attributes
    ----------
    normals : (M, k) in unit of ``scale``
    scale : (k,) the vehicle's ``wrench_scale`` [N, N m]
    push : (M, n) how far one newton of each thruster goes along a normal, the largest in a row 1 [-]
    parts : the pairs in parts that share no thruster
    """

    normals: FloatArray
    scale: FloatArray
    push: FloatArray
    parts: list[IndexArray]

    def met(self, D: FloatArray) -> list[int]:
        """Those that steps D (tau - w) of a level go towards or away from, part by part."""
        along = np.abs(self.normals @ (D * (self.scale / self.scale[:, None])))
        return [m for part in self.parts for m in part.tolist() if along[m].max() > NOTHING]

    def part_of(self, m: int) -> int:
        """The index of the part that a pair belongs to."""
        return next(j for j, part in enumerate(self.parts) if m in part)

    def thrusters(self, part: int) -> list[int]:
        """The thrusters that push along facets of this part."""
        return np.flatnonzero(self.push[self.parts[part]].any(axis=0)).tolist()


def facet_pairs(vehicle: Vehicle) -> FacetPairs:
    """The facets of this vehicle; raises NotApplicable where there are too many to write them out."""
    found = edge(vehicle)
    if len(found.normals) > FACETS_LIMIT:
        raise NotApplicable(
            f"generated C: each facet is written out, here {len(found.normals)} pairs, more than "
            f"{FACETS_LIMIT}; use the method in Python"
        )
    # Stretched until the thruster that pushes most does so by one newton a newton: on many vehicles what is
    # left along a facet is then a plain sum.
    push = snapped(found.push / np.abs(found.push).max(axis=1)[:, None])
    return FacetPairs(
        normals=found.normals * found.scale,
        scale=found.scale,
        push=push,
        parts=components(push != 0),
    )


def components(linked: BoolArray) -> list[IndexArray]:
    """The rows of (M, n) in parts that share no column."""
    near = linked @ linked.T
    for _ in range(linked.shape[1].bit_length()):  # each product doubles the way that is gone
        near = near @ near
    return [np.flatnonzero(row) for row in np.unique(near, axis=0)[::-1]]


def alike(pairs: list[int], along: FloatArray) -> list[list[tuple[int, bool]]]:
    """Pairs of facets along which every step advances equally, in groups; along (M, k) has their rows.

    The boolean of a pair says whether a step advances along it opposite to its group's first.
    """
    groups: dict[tuple[float, ...], list[tuple[int, bool]]] = {}
    for m, row in zip(pairs, snapped(along) if along.size else along, strict=True):
        turned = bool(row[np.flatnonzero(row)[:1]].sum() < 0)
        groups.setdefault(tuple((-row if turned else row).tolist()), []).append((m, turned))
    return [[(m, turned != group[0][1]) for m, turned in group] for group in groups.values()]


def steps_along(
    push: FloatArray, steps: dict[int, Expression], products: dict[int, Terms], name: str
) -> list[Terms]:
    """Length of a step along each normal, push d: each row's terms.

    They are sums of the ``steps`` d of thrusters, or of the products that each d adds up (if all of them do),
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
            # A step adds a product up twice where axes that a failure made one ask for the same.
            spread[i, values.index(value)] += -1.0 if minus else 1.0
    of_products = summed(push @ spread, values, f"go{name}")
    return of_steps.rows if of_steps.terms <= of_products.terms else of_products.rows
