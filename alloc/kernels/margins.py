"""Margins of facets: distances from the wrench of thrusts f to the edge of the attainable set."""

from collections.abc import Sequence

import numpy as np

from alloc.allocation import FloatArray
from alloc.kernels.facets import FacetPairs
from alloc.program import Builder, Expression, Number, least, most, select, size
from alloc.program.graph import lifted
from alloc.program.sums import SAME, is_constant, signed, summed
from alloc.reach.edge import slack_table

Ways = list[tuple[Expression, list[tuple[int, bool]]]]
"""Lengths of a step along normals, each with its pairs of facets and whether a pair points backwards."""

WIDE = 1e-3
"""Margin over the largest limit above which the rounding of a step is negligible [-]."""


def margin_share(along: Expression, ahead: Number, astern: Number) -> Expression:
    """Length ``along`` over the margin ahead, or where it is negative over the margin astern [-]."""
    if max(map(abs, values(ahead - astern))) <= SAME * min(values(ahead)):
        return size(along * (1.0 / least(ahead, astern)))
    share: Expression = most(along * (1.0 / ahead), -along * (1.0 / astern))
    return share


def values(number: Number) -> tuple[float, ...]:
    """Values of a constant, one for each fault; empty if it is only known in a call."""
    return number.graph.fixed_values(number.node) if isinstance(number, Expression) else (number,)


class FacetMargins:
    """Margins ahead and astern of each pair of facets: weighted sums of the thrusts' distances to limits."""

    def __init__(self, builder: Builder, facets: FacetPairs) -> None:
        """Begin without a margin."""
        self._builder, self._facets = builder, facets
        self._known: dict[int, tuple[Number, Number]] = {}
        self._terms: dict[Number, list[Expression]] = {}
        self._gaps: dict[int, tuple[Number, Number]] = {}
        self._narrow, self._spent = set[int](), set[int]()

    def measure(self, level: str, pairs: list[int], f: Sequence[Number]) -> None:
        """Compute the margins from thrusts f of those pairs that have none yet."""
        graph, limits, n = self._builder.graph, self._builder.limits, self._builder.vehicle.n
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
        widths = np.array([gap if is_constant(gap) else 0.0 for gap in gaps], dtype=float)
        rows = summed(table, [lifted(gap, graph) for gap in gaps], f"g{level}_").rows
        if not limits.at_call:
            # A shared sum has no value of its own for each fault; its constants do.
            each = np.array([np.broadcast_to(values(gap), max(len(self._builder.faults), 1)) for gap in gaps])
            narrow = (table @ each <= WIDE * self._builder.vehicle.f_scale).any(axis=1)
            self._narrow |= {m for j, m in enumerate(asked) if narrow[j] or narrow[len(asked) + j]}
        for j, m in enumerate(asked):
            if all(is_constant(gaps[i]) for i in np.flatnonzero(push[j]).tolist()):
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
        """The margin; for a fault that takes a facet's only thruster, that of the whole vehicle.

        Such a facet sees rounding only (``alloc.kernels.failures.reachable``). A margin of zero would have to
        be compared in each call.
        """
        each, faults = values(margin), self._builder.faults
        if not faults or len(each) < len(faults) or np.count_nonzero(push) > 1:
            return margin
        alone = int(np.flatnonzero(push)[0])
        left = [each[0] if fault == alone else m for fault, m in zip(faults, each, strict=True)]
        return margin.graph.of_each(left)

    def load(self, along: Expression, group: list[tuple[int, bool]], tiny: Number) -> Expression:
        """Length of a step over the least margin of these pairs [-].

        ``along`` is the step's length along the pairs' normals (backwards where a pair is turned); below
        ``tiny`` it is rounding. 0/0 is NaN, which comparisons and the FPU's maximum both drop; a step into
        no margin gives infinity, and so a share of zero.
        """
        margins = [self._known[m][:: -1 if turned else 1] for m, turned in group]
        ahead, astern = (self._least(list(side)) for side in zip(*margins, strict=True))
        wide = WIDE * self._builder.vehicle.f_scale
        both = values(ahead), values(astern)
        if all(both) and min(map(min, both)) > wide:
            return margin_share(along, ahead, astern)
        self._builder.compute(along, ahead, astern, tiny)
        step = select(size(along) > tiny, size(along), 0.0)
        margin: Expression = select(along > 0.0, ahead, astern)
        # A margin that was used up may be slightly negative by rounding.
        spent = not self._spent.isdisjoint(m for m, _ in group)
        return step / (most(margin, 0.0) if spent else margin)

    def advance(self, steps: dict[int, Expression], share: Expression, ways: Ways) -> None:
        """Update the margins after thrusters moved by ``steps``, a share of ``ways`` along the normals.

        With the vehicle's own limits the length of the step is subtracted. With limits of the call the
        margins are computed again, which is shorter than to keep them.
        """
        if not self._builder.limits.at_call:
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
        if all(is_constant(margin) for margin in margins):
            return min(margin for margin in margins if isinstance(margin, float))
        # If each value of one list is added to each of another, the least sum is the sum of both minima.
        pairs = [self._terms.get(margin, []) for margin in margins]
        if len(pairs) > 1 and all(len(pair) == 2 for pair in pairs):
            # One list: the partners of the first pair's second value; the other: all other values.
            these = {a for pair in pairs if pairs[0][1] in pair for a in pair} - {pairs[0][1]}
            those = {value for pair in pairs for value in pair} - these
            each = {frozenset((a, b)) for a in these for b in those}
            if len(these) * len(those) == len(pairs) and each == {frozenset(pair) for pair in pairs}:
                some, others = (sorted(side, key=lambda value: value.node) for side in (these, those))
                total: Expression = least(*some) + least(*others)
                return total
        found: Number = least(*margins)
        return found
