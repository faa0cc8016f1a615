"""How far rounding takes thrusts from what the kernel's own formula gives in real numbers: a bound.

Every operation is followed with the range of its exact value over all attainable demands, tau = T P f within
the limits, and a bound on how far the calculated value is from it. A linear value has the range of the
attainable set along its direction, without loss; minimum and maximum move by no more than their operands do.
"""

from collections import ChainMap
from collections.abc import MutableMapping
from dataclasses import dataclass, replace
from math import floor, frexp, log2

import numpy as np

from alloc import FloatArray, Vehicle
from alloc.native.code import Scalar
from bench.prove.program import Node, NotRead, Operation, Program
from bench.prove.regions import Region, both, compared, regions

DIGITS: dict[Scalar, int] = {"double": 53, "float": 24}
TINIEST: dict[Scalar, float] = {"double": 2.0**-1075, "float": 2.0**-150}
"""Half of the smallest subnormal number, which a product may lose."""
WIDER: dict[Scalar, float] = {"double": 1e-13, "float": 1e-6}
"""By how much ranges are widened, relative to their size: for demands that rounding takes out of the
attainable set, and for rounding in this analysis itself."""

DEPTH = 2
"""How many branches may stand in each other: their regions multiply."""

Atom = tuple[Node, int]
"""What a value is linear in: an entry of tau, times a share where the node is not -1."""


@dataclass(frozen=True)
class Value:
    """One value of a program.

    Attributes
    ----------
    low, high : range of the exact value
    error : how far the calculated value may be from it
    form : factors of the atoms it is a sum of; None where it is no such sum
    """

    low: float
    high: float
    error: float
    form: dict[Atom, float] | None = None

    @property
    def size(self) -> float:
        """Largest size of the exact value."""
        return max(abs(self.low), abs(self.high))


class Errors:
    """The values of a program, each with its range and error.

    ``exact`` gives constants before they were rounded to the scalar, by node.
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
        self._nodes, self._vehicle, self._scalar, self._exact = program.nodes, vehicle, scalar, exact or {}
        self._flips, self._depth = flips, 0
        self.values: MutableMapping[Node, Value] = {}
        self.reasons: dict[Node, str] = {}
        for node, operation in enumerate(program.nodes):
            branch = operation[0] == "choose"  # of its values each counts only where it is taken
            lost = [each for each in _operands(operation) if each in self.reasons and not branch]
            if lost:
                self.reasons[node] = self.reasons[lost[0]]
                continue
            try:
                if (value := self._value(node, operation)) is not None:
                    self.values[node] = value
            except NotRead as reason:
                self.reasons[node] = str(reason)

    def error(self, node: Node) -> float:
        """The bound on a node's error; raises NotRead where there is none."""
        if node not in self.values:
            raise NotRead(self.reasons.get(node, "no number"))
        return self.values[node].error

    def _value(self, node: Node, operation: Operation) -> Value | None:
        match operation:
            case ("const", value):
                exact = self._exact.get(node, float(value))
                return Value(exact, exact, abs(value - exact), {})
            case ("input", "tau", j):
                return self._linear({(-1, j): 1.0}, 0.0)
            case ("input", name, _):
                raise NotRead(f"{name} is an argument")
            case ("unknown",):
                raise NotRead("loops that data end")
            case ("choose", condition, then, other):
                return self._chosen(condition, then, other)
        operands = [self.values.get(each) for each in operation[1:]]
        if any(each is None for each in operands):
            return None  # of conditions
        known = [each for each in operands if each is not None]
        combine = getattr(self, f"_{operation[0]}", None)
        if combine is None:
            return None
        made: Value = combine(*known, *operation[1:]) if operation[0] == "mul" else combine(*known)
        return made

    def _chosen(self, condition: Node, then: Node, other: Node) -> Value:
        match self._nodes[condition]:
            case ("lt", x, bound) if x == then and x in self.values and bound in self.values:
                # x below the bound, else a constant: on the wrong side x is within its error of the bound.
                a, b, limit = self.values[x], self.values.get(other), self.values[bound]
                if b is not None and b.low == b.high:
                    if a.low - a.error >= limit.high + limit.error:
                        return b
                    jump = abs(limit.low - b.low)
                    return Value(min(a.low, b.low), max(min(a.high, b.high), b.high), a.error + jump)
        sides = [
            self._under(branch, condition, holds, {}) for branch, holds in ((then, True), (other, False))
        ]
        value = _union([each for side in sides for each in side])
        jump = self._jump(condition, then, other) if self._flips else 0.0
        return replace(value, error=value.error + jump)

    def _under(self, branch: Node, condition: Node, holds: bool, near: Region) -> list[Value]:
        """A branch's values where a condition holds, or does not, one for each region of that."""
        ranges = {node: (value.low, value.high) for node, value in self.values.items()}
        found = []
        for region in regions(self._nodes, ranges, condition, holds):
            within = both(region, near)
            narrowed = within and both({node: ranges[node] for node in within if node in ranges}, within)
            if within == {} or narrowed:
                found.append(self._again(branch, narrowed or {}))
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
                made[node] = replace(kept[node], low=region[node][0], high=region[node][1], form=None)
            for node in _cone(self._nodes, root):
                operands = set(_operands(self._nodes[node]))
                if node not in changed and (operands & changed or node not in kept):
                    value = self._value(node, self._nodes[node])
                    if value is not None:
                        made[node] = value
                    changed.add(node)
            if root not in self.values:
                raise NotRead(self.reasons.get(root, "a choice between what is no number"))
            return self.values[root]
        finally:
            self.values, self._depth = kept, self._depth - 1

    def _jump(self, condition: Node, then: Node, other: Node) -> float:
        """How far the two branches may lie apart where rounding turns a comparison of the condition."""
        most = 0.0
        for a, b in compared(self._nodes, condition):
            if a not in self.values or b not in self.values:
                raise NotRead("a branch on what is no number")
            x, y = self.values[a], self.values[b]
            room = x.error + y.error
            near = {a: (y.low - room, y.high + room), b: (x.low - room, x.high + room)}
            one = self._under(then, condition, True, near)
            two = self._under(other, condition, False, near)
            gaps = [max(p.high - q.low, q.high - p.low) for p in one for q in two]
            most = max([most, *gaps])
        return most

    def _linear(self, form: dict[Atom, float], error: float) -> Value:
        low = high = 0.0
        for share in {node for node, _ in form}:
            along = np.array([form.get((share, j), 0.0) for j in range(self._vehicle.k)])
            ends = _support(self._vehicle, along)
            low += ends[0] if share < 0 else min(ends[0], 0.0)
            high += ends[1] if share < 0 else max(ends[1], 0.0)
        wider = WIDER[self._scalar] * max(abs(low), abs(high))
        return Value(low - wider, high + wider, error, form)

    def _rounded(self, value: Value) -> Value:
        most = value.size + value.error
        half = 2.0 ** (floor(log2(most)) - DIGITS[self._scalar]) if most > 0 else 0.0
        return Value(value.low, value.high, value.error + half + TINIEST[self._scalar], value.form)

    def _sum(self, a: Value, b: Value, sign: float) -> Value:
        error = a.error + b.error
        ends = sorted((sign * b.low, sign * b.high))
        form = None
        if a.form and b.form:
            form = dict(a.form)
            for atom, factor in b.form.items():
                form[atom] = form.get(atom, 0.0) + sign * factor
        total = self._linear(form, error) if form else Value(a.low + ends[0], a.high + ends[1], error)
        exact = (a.low == a.high == 0.0 and not a.error) or (b.low == b.high == 0.0 and not b.error)
        return total if exact else self._rounded(total)

    def _add(self, a: Value, b: Value) -> Value:
        return self._sum(a, b, 1.0)

    def _sub(self, a: Value, b: Value) -> Value:
        return self._sum(a, b, -1.0)

    def _neg(self, a: Value) -> Value:
        form = {atom: -factor for atom, factor in a.form.items()} if a.form else None
        return Value(-a.high, -a.low, a.error, form)

    def _abs(self, a: Value) -> Value:
        return Value(0.0 if a.low <= 0 <= a.high else min(abs(a.low), abs(a.high)), a.size, a.error)

    def _min(self, a: Value, b: Value) -> Value:
        return Value(min(a.low, b.low), min(a.high, b.high), max(a.error, b.error))

    def _max(self, a: Value, b: Value) -> Value:
        return Value(max(a.low, b.low), max(a.high, b.high), max(a.error, b.error))

    def _mul(self, a: Value, b: Value, left: Node, right: Node) -> Value:
        error = a.error * b.size + b.error * a.size + a.error * b.error
        corners = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
        value = Value(min(corners), max(corners), error)
        for factor, other in ((a, b), (b, a)):
            if factor.low == factor.high and other.form:
                value = self._linear({atom: factor.low * each for atom, each in other.form.items()}, error)
        for node, share, other in ((left, a, b), (right, b, a)):
            is_share = share.form is None and share.low >= 0.0 and share.high <= 1.0
            if is_share and other.form and all(atom[0] < 0 for atom in other.form):
                value = self._linear({(node, j): each for (_, j), each in other.form.items()}, error)
        doubled = any(each.low == each.high and abs(frexp(each.low)[0]) == 0.5 for each in (a, b))
        return value if doubled else self._rounded(value)  # a power of two rounds nothing but what is tiny

    def _div(self, a: Value, b: Value) -> Value:
        least = min(abs(b.low), abs(b.high)) if b.low > 0 or b.high < 0 else 0.0
        if least <= b.error:
            raise NotRead("a division by what may be zero")
        corners = [x / y for x in (a.low, a.high) for y in (b.low, b.high)]
        size = max(abs(each) for each in corners)
        return self._rounded(
            Value(min(corners), max(corners), (a.error + size * b.error) / (least - b.error))
        )


def _union(values: list[Value]) -> Value:
    if not values:
        raise NotRead("a choice that is never made")
    error = max(each.error for each in values)
    return Value(min(each.low for each in values), max(each.high for each in values), error)


def _cone(nodes: list[Operation], root: Node) -> list[Node]:
    """A node and all that it is made of, operands first."""
    found, waiting = set[Node](), [root]
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting += _operands(nodes[node])
    return sorted(found)


def _operands(operation: Operation) -> tuple[Node, ...]:
    return () if operation[0] in ("const", "input", "unknown") else operation[1:]


def _support(vehicle: Vehicle, along: FloatArray) -> tuple[float, float]:
    """Least and largest along . tau over all attainable tau."""
    push = along @ vehicle.TP
    ends = np.sort([push * vehicle.f_min, push * vehicle.f_max], axis=0)
    return float(ends[0].sum()), float(ends[1].sum())
