"""The margin of each facet: how far the attainable set reaches beyond the wrench reached so far."""

from collections.abc import Sequence

import numpy as np

from alloc.allocation import FloatArray
from alloc.kernels.facets import FacetPairs
from alloc.program import Builder, Expression, Number, least, most, select, size
from alloc.program.graph import lifted
from alloc.program.sums import SAME, known, signed, summed
from alloc.reach.edge import slack_table

Ways = list[tuple[Expression, list[tuple[int, bool]]]]
"""Lengths of a step along the normals of pairs of facets, or where a pair is turned their opposites."""

WIDE = 1e-3
"""Margin of a facet, as a share of the largest limit, beyond which rounding of a step along it is
nothing to it."""


def taken(along: Expression, ahead: Number, astern: Number) -> Expression:
    """The share that ``along`` takes of the margin ahead of it, or astern where it is negative."""
    if max(map(abs, values(ahead - astern))) <= SAME * min(values(ahead)):
        return size(along * (1.0 / least(ahead, astern)))
    share: Expression = most(along * (1.0 / ahead), -along * (1.0 / astern))
    return share


def values(number: Number) -> tuple[float, ...]:
    """A number's value for each fault that has its own; empty where it is not known beforehand."""
    return number.graph.known(number.node) if isinstance(number, Expression) else (number,)


class FacetMargins:
    """The margins ahead and astern of each pair of facets: sums of what lies between thrusts and limits."""

    def __init__(self, builder: Builder, facets: FacetPairs) -> None:
        """No margin is known yet."""
        self._draft, self._facets = builder, facets
        self._known: dict[int, tuple[Number, Number]] = {}
        self._terms: dict[Number, list[Expression]] = {}
        self._gaps: dict[int, tuple[Number, Number]] = {}
        self._narrow, self._spent = set[int](), set[int]()

    def measure(self, level: int, pairs: list[int], f: Sequence[Number]) -> None:
        """Find the margins from thrusts f, of those pairs whose margins are not known."""
        graph, limits, n = self._draft.graph, self._draft.limits, self._draft.vehicle.n
        asked = [m for m in pairs if m not in self._known]
        push = self._facets.push[asked]
        pushing = np.flatnonzero(push.any(axis=0)).tolist()
        gaps: list[Number] = [0.0] * (2 * n)
        for i in pushing:
            low, high = limits.ends(i)
            up, down = self._gaps.get(i, (high - f[i], f[i] - low))
            for at, gap in ((i, up), (n + i, down)):
                gaps[at] = gap.named(f"g{level}_{at}") if isinstance(gap, Expression) else gap
            if limits.at_call:
                self._gaps[i] = gaps[i], gaps[n + i]
        table = slack_table(push)
        widths = np.array([gap if known(gap) else 0.0 for gap in gaps], dtype=float)
        rows = summed(table, [lifted(gap, graph) for gap in gaps], f"g{level}_").rows
        if not limits.at_call:
            # Of a shared sum only its numbers tell what it is for each fault.
            each = np.array([np.broadcast_to(values(gap), max(len(self._draft.faults), 1)) for gap in gaps])
            narrow = (table @ each <= WIDE * self._draft.vehicle.f_scale).any(axis=1)
            self._narrow |= {m for j, m in enumerate(asked) if narrow[j] or narrow[len(asked) + j]}
        for j, m in enumerate(asked):
            if all(known(gaps[i]) for i in np.flatnonzero(push[j]).tolist()):
                ahead, astern = (float(table[row] @ widths) for row in (j, len(asked) + j))
                self._known[m] = ahead, astern
                continue
            sums = [self._whole(signed(rows[row], graph), push[j]) for row in (j, len(asked) + j)]
            self._known[m] = sums[0], sums[1]
            for value, row, way in zip(
                sums, (rows[j], rows[len(asked) + j]), ("ahead", "astern"), strict=True
            ):
                if isinstance(value, Expression):
                    self._terms[value.named(f"{way}{level}_{m}")] = [each for _, each in row]

    def _whole(self, margin: Expression, push: FloatArray) -> Number:
        """The margin, where a fault leaves a facet no thruster that of the whole vehicle.

        Nothing of a demand goes along it then but rounding (``alloc.kernels.off.reachable``), of which any
        margin takes nothing; one of zero would have to be looked at in each call.
        """
        each, faults = values(margin), self._draft.faults
        if not faults or len(each) < len(faults) or np.count_nonzero(push) > 1:
            return margin
        alone = int(np.flatnonzero(push)[0])
        left = [each[0] if fault == alone else m for fault, m in zip(faults, each, strict=True)]
        return margin.graph.of_each(left)

    def load(self, along: Expression, group: list[tuple[int, bool]], tiny: Number) -> Expression:
        """Share of the least margin of these pairs that a step uses up.

        ``along`` is how far it goes along the pairs' normals, or where a pair is turned their opposites, and
        what is smaller than ``tiny`` is rounding. Nothing of no margin is NaN, which compares and the FPU's
        maximum drop alike; something of none is infinite, so the share is zero.
        """
        margins = [self._known[m][:: -1 if turned else 1] for m, turned in group]
        ahead, astern = (self._least(list(side)) for side in zip(*margins, strict=True))
        wide = WIDE * self._draft.vehicle.f_scale
        both = values(ahead), values(astern)
        if all(both) and min(map(min, both)) > wide:
            return taken(along, ahead, astern)
        self._draft.compute(along, ahead, astern, tiny)
        step = select(size(along) > tiny, size(along), 0.0)
        margin: Expression = select(along > 0.0, ahead, astern)
        # What is left of no margin may be negative by rounding, and so would be the share of it.
        spent = not self._spent.isdisjoint(m for m, _ in group)
        return step / (most(margin, 0.0) if spent else margin)

    def moved(self, steps: dict[int, Expression], share: Expression, ways: Ways) -> None:
        """The way has gone on: thrusters by these steps, and along pairs' normals by a share of these ways.

        Margins of a vehicle's own limits are known at the start, so only the way is taken off. Those of the
        call's are measured again: it is shorter than to keep them, or to read limits again.
        """
        if not self._draft.limits.at_call:
            for along, group in ways:
                by = share * along
                self._spent |= {m for m, _ in group} & self._narrow
                for m, turned in group:
                    ahead, astern = self._known[m]
                    self._known[m] = (ahead + by, astern - by) if turned else (ahead - by, astern + by)
            return
        for i in steps.keys() & self._gaps.keys():
            up, down = self._gaps[i]
            self._gaps[i] = (up - steps[i], down + steps[i])
        touched = {*np.flatnonzero(self._facets.push[:, list(steps)].any(axis=1)).tolist()}
        self._spent |= touched
        for m in self._known.keys() & touched:
            del self._known[m]

    def _least(self, margins: list[Number]) -> Number:
        margins = list(dict.fromkeys(margins))
        if all(known(margin) for margin in margins):
            return min(margin for margin in margins if isinstance(margin, float))
        # Where each value of one list is added to each of another, the least sum is the sum of minima.
        pairs = [self._terms.get(margin, []) for margin in margins]
        if len(pairs) > 1 and all(len(pair) == 2 for pair in pairs):
            # One list: what is added to the first pair's second value. The other: all remaining values.
            these = {a for pair in pairs if pairs[0][1] in pair for a in pair} - {pairs[0][1]}
            those = {value for pair in pairs for value in pair} - these
            each = {frozenset((a, b)) for a in these for b in those}
            if len(these) * len(those) == len(pairs) and each == {frozenset(pair) for pair in pairs}:
                some, others = (sorted(side, key=lambda value: value.node) for side in (these, those))
                total: Expression = least(*some) + least(*others)
                return total
        found: Number = least(*margins)
        return found
