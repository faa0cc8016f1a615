"""C of the room along each facet: how far the set reaches beyond the thrusts that a way has come to."""

from collections.abc import Sequence

import numpy as np

from alloc.native.bounds import CLimits
from alloc.native.code import Table, Value, defined, expression, fold, signed_sum, summed
from alloc.native.facets import FacetPairs
from alloc.reach.edge import room_table
from alloc.vehicle import Vehicle

ROOMY = 1e-3
"""Where a facet leaves more room than this share of the largest limit, rounding of a step along it is nothing
to it."""


def taken(along: str, ahead: float, astern: float, c: Table) -> str:
    """C of the share that ``along`` takes of the room ahead of it, or astern where it is negative."""
    if ahead == astern:
        return f"size({along} * {c(1.0 / ahead)})"
    return f"most({along} * {c(1.0 / ahead)}, -{along} * {c(1.0 / astern)})"


class Rooms:
    """The room ahead and astern of each pair of facets: sums of what lies between thrusts and limits."""

    def __init__(self, vehicle: Vehicle, facets: FacetPairs, bounds: CLimits, c: Table) -> None:
        """No room is known yet."""
        self._vehicle, self._facets, self._bounds, self._c = vehicle, facets, bounds, c
        self._known: dict[int, tuple[Value, Value]] = {}
        self._sums: dict[Value, list[str]] = {}
        self._gaps: dict[int, tuple[str, str]] = {}

    def measure(self, level: int, pairs: list[int], f: Sequence[Value]) -> list[str]:
        """Definitions of the rooms from thrusts f, of those pairs that no level has measured before."""
        c, n, vehicle = self._c, self._vehicle.n, self._vehicle
        asked = [m for m in pairs if m not in self._known]
        push = self._facets.push[asked]
        table, widths = room_table(push), np.zeros(2 * n)
        lines = []
        for i in np.flatnonzero(push.any(axis=0)).tolist():
            (low, high), at = self._bounds.ends(i), f[i]
            up, down = self._gaps.get(i, (f"{high} - {expression(at, c)}", f"{expression(at, c)} - {low}"))
            lines += [defined(f"g{level}_{i}", up, c), defined(f"g{level}_{n + i}", down, c)]
            if self._bounds.at_call:
                self._gaps[i] = (f"g{level}_{i}", f"g{level}_{n + i}")
            elif isinstance(at, float):
                widths[[i, n + i]] = vehicle.f_max[i] - at, at - vehicle.f_min[i]
        sums, rows, _ = summed(table, f"g{level}_", c, f"g{level}_")
        lines += sums
        values = (table @ widths).tolist()
        for j, m in enumerate(asked):
            ahead, astern = j, len(asked) + j
            if not self._bounds.at_call and all(
                isinstance(f[i], float) for i in np.flatnonzero(push[j]).tolist()
            ):
                self._known[m] = values[ahead], values[astern]
                continue
            self._known[m] = names = f"room{level}_{m}", f"back{level}_{m}"
            for name, row in zip(names, (rows[ahead], rows[astern]), strict=True):
                lines.append(defined(name, signed_sum(row, c.scalar), c))
                self._sums[name] = [text for _, text in row]
        return lines

    def load(self, along: str, group: list[tuple[int, bool]], tiny: str) -> str:
        """What a step takes of the least room that one of these pairs leaves it.

        ``along`` is how far it goes along the pairs' normals, or where a pair is turned their opposites, and
        what is smaller than ``tiny`` is rounding.
        """
        rooms = [self._known[m][:: -1 if turned else 1] for m, turned in group]
        ahead, astern = (self._least(list(side)) for side in zip(*rooms, strict=True))
        roomy, c = ROOMY * self._vehicle.f_scale, self._c
        if isinstance(ahead, float) and isinstance(astern, float) and min(ahead, astern) > roomy:
            return taken(along, ahead, astern, c)
        return f"load({along}, {expression(ahead, c)}, {expression(astern, c)}, {tiny})"

    def moved(self, steps: dict[int, str]) -> None:
        """Thrusters have moved by these C expressions: rooms along what they push must be measured again."""
        for i in steps.keys() & self._gaps.keys():  # so that limits need not be kept, nor read again
            up, down = self._gaps[i]
            self._gaps[i] = (f"{up} - {steps[i]}", f"{down} + {steps[i]}")
        touched = np.flatnonzero(self._facets.push[:, list(steps)].any(axis=1))
        for m in self._known.keys() & {*touched.tolist()}:
            del self._known[m]

    def _least(self, rooms: list[Value]) -> Value:
        known = [room for room in rooms if isinstance(room, float)]
        if len(known) == len(rooms):
            return min(known)
        # The least of all sums of one of these and one of those is the sum of the least.
        pairs = [self._sums.get(room, []) for room in rooms]
        if len(pairs) > 1 and all(len(pair) == 2 for pair in pairs):
            # Those that stand with what the first pair's second stands with.
            these = {a for pair in pairs if pairs[0][1] in pair for a in pair} - {pairs[0][1]}
            those = {text for pair in pairs for text in pair} - these
            each = {frozenset((a, b)) for a in these for b in those}
            if len(these) * len(those) == len(pairs) and each == {frozenset(pair) for pair in pairs}:
                return f"{fold('least', sorted(these))} + {fold('least', sorted(those))}"
        return fold("least", [expression(room, self._c) for room in rooms])
