"""How far rounding takes thrusts from what the kernel's own formula gives in real numbers: a bound.

Every operation is followed with the range of its exact value over all attainable demands, tau = T P f within
the limits, and a bound on how far the calculated value is from it. A linear value has the range of the
attainable set along its direction, without loss; minimum and maximum move by no more than their operands do.
"""

from collections import ChainMap
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import replace
from math import inf, isfinite

from alloc import Vehicle
from alloc.program import Node, Operation, Program, Scalar, operands, reachable
from bench.proof.rounding.arithmetic import DIGITS, Arithmetic, Value, among
from bench.proof.rounding.products import NOTHING, ONE, constant, exact
from bench.proof.rounding.shares import Share, gauges, shares
from bench.proof.source import NotRead

Region = dict[Node, tuple[float, float]]
"""Ranges of some numbers; of all others nothing is said."""
OPPOSITE = {"lt": "ge", "le": "gt", "gt": "le", "ge": "lt", "eq": "ne", "ne": "eq"}

DEPTH = 2
"""How many branches may stand in each other: their regions multiply."""


class Errors(Arithmetic):
    """The values of a program, each with its range and error.

    ``exact`` gives constants before they were rounded to the scalar, by node. Thrusts are followed, and what
    decides whether they are written; ``branches`` says whether thrusts hang on any.
    """

    def __init__(
        self,
        program: Program,
        vehicle: Vehicle,
        scalar: Scalar,
        exact: dict[Node, float] | None = None,
        flips: bool = False,
    ) -> None:
        """Follow the errors; values that can't be followed are missing, and so are all made of them.

        A branch is taken as in real numbers; with ``flips`` also otherwise, wherever rounding may have it so.
        """
        super().__init__(vehicle, scalar)
        self._nodes, self._exact = program.nodes, exact or {}
        self._flips, self._depth = flips, 0
        self.values: MutableMapping[Node, Value] = {}
        self.reasons: dict[Node, str] = {}
        self._shares = shares(program.nodes)
        self._within = within = set().union(*(each.inner for each in self._shares.values()))
        self._thrusts = [node for (name, _), node in program.outputs.items() if name == "f"]
        needed = set(reachable(program.nodes, tuple(self._thrusts))) - within
        self.branches = any(program.nodes[node][0] == "choose" for node in needed)
        needed |= set(reachable(program.nodes, tuple(root for root, _ in program.exits))) - within
        for node in sorted(needed):  # nodes of a share are followed when the share is
            operation = program.nodes[node]
            branch = operation[0] == "choose"  # a side that is not taken does not count
            lost = [each for each in operands(operation) if each in self.reasons and not branch]
            if lost:
                self.reasons[node] = self.reasons[lost[0]]
                continue
            try:
                if (value := self._value(node, operation)) is not None:
                    self.values[node] = value
            except NotRead as reason:
                self.reasons[node] = str(reason)

    def bound(self) -> float:
        """The bound of all thrusts [N]; raises NotRead where one has none."""
        return max(map(self.error, self._thrusts))

    def error(self, node: Node) -> float:
        """The bound on a node's error; raises NotRead where there is none."""
        if isfinite(error := self._plain(self._number(node)).error):
            return error
        raise NotRead("no bound was found")

    def _value(self, node: Node, operation: Operation) -> Value | None:
        match operation:
            case ("const", value):
                true = self._exact.get(node, float(value))
                added = self._sensitivity.added(abs(value - true)) if true != value else {}
                return self._linear(constant(true) | added)
            case ("input", "tau", j):
                return self._linear({(NOTHING, j): 1.0})
            case ("input", name, _):
                raise NotRead(f"{name} is an argument")
            case ("unknown",):
                raise NotRead("loops that data end")
            case ("choose", condition, then, other):
                return self._chosen(condition, then, other)
        if node in self._shares:
            return self._followed(node, self._shares[node], operation)
        given = [self.values.get(each) for each in operation[1:]]
        combine = getattr(self, f"_{operation[0]}", None)
        if combine is None or None in given:
            return None  # a condition, or made of one
        made: Value = combine(*given)
        return made

    def _followed(self, node: Node, share: Share, operation: Operation) -> Value:
        """A share as such, or where that can't be as any other quotient; raises NotRead."""
        try:
            return self._share(node, share)
        except NotRead as reason:
            for each in sorted(share.inner):
                try:
                    if (value := self._value(each, self._nodes[each])) is not None:
                        self.values[each] = value
                except NotRead as other:
                    self.reasons[each] = str(other)
            _, above, below = operation
            if below not in self.values:
                raise reason from None
            return self._div(self.values[above], self.values[below])

    def _share(self, node: Node, share: Share) -> Value:
        """Share k / max(k, loads): the gauge that holds it below 1, and itself as a form."""
        keep, least = self.values[share.keep], self.values[share.least]
        if not keep.low == least.low > 0.0:
            raise NotRead("a share of two different numbers")
        digits, k = 2.0 ** -DIGITS[self._scalar], keep.low
        found, roundings = gauges(share, self._number)
        relative = 1.001 * roundings * digits + 2.0 * (keep.error + least.error) / k
        self._sensitivity.add(node, k, found, relative)
        return Value(0.0, 1.0, 0.0, {(frozenset({node}), ONE): 1.0})

    def _number(self, node: Node) -> Value:
        if node not in self.values:
            raise NotRead(self.reasons.get(node, "no number"))
        return self.values[node]

    def _chosen(self, condition: Node, then: Node, other: Node) -> Value:
        match self._nodes[condition]:
            case ("lt", x, bound) if x == then and x in self.values and bound in self.values:
                # x below the bound, else a constant: on the wrong side x is within its error of the bound.
                b = self.values.get(other)
                if b is not None and b.low == b.high:
                    a, limit = self._plain(self.values[x]), self._plain(self.values[bound])
                    if a.low - a.error >= limit.high + limit.error:
                        return b
                    jump = abs(limit.low - b.low)
                    return Value(min(a.low, b.low), max(min(a.high, b.high), b.high), a.error + jump)
        if other in self.values and self._never(condition):
            return self.values[other]
        match self._nodes[then]:
            case ("sub", same, less) if same == other:
                return self._lessened(condition, other, less)
        value = _union([*self._under(then, condition, True, {}), *self._under(other, condition, False, {})])
        jump = self._jump(condition, then, other) if self._flips else 0.0
        return replace(value, error=value.error + jump)

    def _never(self, condition: Node) -> bool:
        """True if no attainable demand fulfils a condition, by linear programs over what it compares.

        That holds in real numbers, and with ``flips`` of what is calculated too.
        """
        match self._nodes[condition]:
            case ("gt", a, b) if a in self.values and self._nodes[b][0] == "const":
                found, bound = among(self.values[a]), self.values[b].low
                return bool(found) and all(self._most(each) < bound for each in found)
        return False

    def _most(self, value: Value) -> float:
        """No less than a value with a form.

        The facts hold for the shares as they were calculated too, so what moves those is in the first number.
        """
        assert value.form is not None
        found = self._products.most(exact(value.form))
        return found + value.error if self._flips else found

    def _lessened(self, condition: Node, other: Node, less: Node) -> Value:
        """Difference of ``other`` and something, which moves by no more than that under a condition."""
        found = self._under(less, condition, True, {})
        if not found:
            return self._number(other)
        whole, part = self._plain(self._number(other)), _union(found)
        low, high = min(0.0, -part.high), max(0.0, -part.low)
        jump = self._jump(condition, less, None) if self._flips else 0.0
        value = self._rounded(Value(whole.low + low, whole.high + high, whole.error + part.error))
        return replace(value, error=value.error + jump)

    def _under(self, branch: Node, condition: Node, holds: bool, near: Region) -> list[Value]:
        """A branch's values where a condition holds, or does not, one for each region of that."""
        ranges = {node: (value.low, value.high) for node, value in self.values.items()}
        found = []
        for region in regions(self._nodes, ranges, condition, holds):
            within = both(region, near)
            narrowed = within and both({node: ranges[node] for node in within if node in ranges}, within)
            if within == {} or narrowed:
                found.append(self._plain(self._again(branch, narrowed or {})))
        return found

    def _again(self, root: Node, region: Region) -> Value:
        """A value where others lie in narrower ranges; raises NotRead."""
        if self._depth >= DEPTH:
            raise NotRead("branches inside branches")
        kept, made = self.values, dict[Node, Value]()
        self.values, self._depth = ChainMap(made, kept), self._depth + 1  # writes go to the first
        try:
            changed = {
                node
                for node, (low, high) in region.items()
                if node in kept and (low > kept[node].low or high < kept[node].high)
            }
            for node in changed:
                made[node] = Value(*region[node], self._plain(kept[node]).error)
            for node in sorted(reachable(self._nodes, (root,))):
                if node in self._within and node not in kept:
                    continue  # it is followed with its share, whose range holds in narrower ranges too
                moved = not changed.isdisjoint(operands(self._nodes[node]))
                if node not in changed and (moved or node not in kept):
                    value = self._value(node, self._nodes[node])
                    if value is not None:
                        made[node] = value
                    changed.add(node)
            if root not in self.values:
                raise NotRead(self.reasons.get(root, "a choice between what is no number"))
            return self.values[root]
        finally:
            self.values, self._depth = kept, self._depth - 1

    def _jump(self, condition: Node, then: Node, other: Node | None) -> float:
        """How far the two branches may lie apart where rounding turns a comparison of the condition.

        Where ``other`` is None that is zero.
        """
        most = 0.0
        for a, b in compared(self._nodes, condition):
            if a not in self.values or b not in self.values:
                raise NotRead("a branch on what is no number")
            x, y = self._plain(self.values[a]), self._plain(self.values[b])
            slack = x.error + y.error
            near = {a: (y.low - slack, y.high + slack), b: (x.low - slack, x.high + slack)}
            one = self._under(then, condition, True, near)
            two = [Value(0.0, 0.0, 0.0)] if other is None else self._under(other, condition, False, near)
            gaps = [max(p.high - q.low, q.high - p.low) for p in one for q in two]
            most = max([most, *gaps])
        return most


def _union(values: list[Value]) -> Value:
    if not values:
        raise NotRead("a choice that is never made")
    error = max(each.error for each in values)
    return Value(min(each.low for each in values), max(each.high for each in values), error)


def regions(
    nodes: Sequence[Operation], ranges: Mapping[Node, tuple[float, float]], condition: Node, holds: bool
) -> list[Region]:
    """Regions that together hold all numbers for which a condition holds, or does not."""
    match nodes[condition]:
        case ("const", value):
            return [{}] if bool(value) == holds else []
        case ("not", inner):
            return regions(nodes, ranges, inner, not holds)
        case ("and" | "or" as operation, a, b):
            if (operation == "and") == holds:
                return _both(regions(nodes, ranges, a, holds), regions(nodes, ranges, b, holds))
            return regions(nodes, ranges, a, holds) + regions(nodes, ranges, b, holds)
        case ("choose", asked, then, other):
            first = _both(regions(nodes, ranges, asked, True), regions(nodes, ranges, then, holds))
            return first + _both(regions(nodes, ranges, asked, False), regions(nodes, ranges, other, holds))
        case (operation, a, b) if operation in OPPOSITE:
            return _compared(ranges, operation if holds else OPPOSITE[operation], a, b)
    return [{}]


def compared(nodes: Sequence[Operation], condition: Node) -> set[tuple[Node, Node]]:
    """The pairs of numbers that a condition compares."""
    match nodes[condition]:
        case (operation, a, b) if operation in OPPOSITE:
            return {(a, b)}
        case ("not" | "and" | "or" | "choose", *inner):
            return set().union(*(compared(nodes, each) for each in inner))
    return set()


def both(a: Region, b: Region) -> Region | None:
    """Intersection of two regions; None where it is empty."""
    found = dict(a)
    for node, (low, high) in b.items():
        before = found.get(node, (-inf, inf))
        found[node] = (max(low, before[0]), min(high, before[1]))
        if found[node][0] > found[node][1]:
            return None
    return found


def _both(some: list[Region], others: list[Region]) -> list[Region]:
    found = [both(a, b) for a in some for b in others]
    return [each for each in found if each is not None]


def _compared(ranges: Mapping[Node, tuple[float, float]], operation: str, a: Node, b: Node) -> list[Region]:
    region: Region = {}
    if operation in ("lt", "le", "eq"):
        region[a] = (-inf, ranges[b][1]) if b in ranges else (-inf, inf)
        region[b] = (ranges[a][0], inf) if a in ranges else (-inf, inf)
    if operation in ("gt", "ge", "eq"):
        above = both(region, {a: (ranges[b][0], inf) if b in ranges else (-inf, inf)})
        above = above and both(above, {b: (-inf, ranges[a][1]) if a in ranges else (-inf, inf)})
        return [] if above is None else [above]
    return [region]
