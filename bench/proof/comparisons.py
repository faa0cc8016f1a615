"""Bounds of numbers where a program answers, from the comparisons that let the answer leave.

A comparison that holds has no NaN in it, and a sum of sizes that is a number has none either. A maximum may
drop NaN, and so does y = min(max(p, low), high): what is known by these holds where no operation overflows.
"""

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from alloc.program import Node, Program, Scalar
from bench.proof.forms import ONE, Form, Forms, Product, number, total

FACTOR = 1e-5
"""Factors that differ by less than this, relative to the larger, differ by rounding of constants."""
ROUNDED = 16.0
"""Roundings of a limit by which a number beyond it counts as rounded, not as permitted."""
ALTERNATIVES = 64
"""Most bounds of one number that are kept."""
Bound = tuple[Node | None, float, bool]
"""A number is no more, or no less, than another one (None for zero) and this; whether NaN may be dropped."""
Bounds = dict[Node, list[Bound]]


class Fact(NamedTuple):
    """A form whose size is bounded by a number and, with ``row``, a weight times the size of a parameter.

    Attributes
    ----------
    form, bound : |form| <= bound
    row, weight : parameter, and its weight; thrust i for i below n, entry j of tau for n + j
    """

    form: Form
    bound: float = 0.0
    row: int | None = None
    weight: float = 1.0


class Comparisons:
    """Facts that hold where a program answers, or answers with SOLVED.

    Attributes
    ----------
    truths : whether a condition holds
    forms : those of numbers
    sizes : numbers, what their sizes are at most, and whether NaN may have been dropped before
    drops : whether what was asked holds only where no operation overflows
    """

    def __init__(
        self,
        program: Program,
        scalar: Scalar,
        known: Mapping[Node, Form],
        *holding: Node,
        missing: Collection[Node] = (),
    ) -> None:
        """No condition of an exit held nor any ``missing``, all ``holding`` do; ``known`` as in ``Forms``."""
        self._nodes, self._known = program.nodes, known
        self.truths, self._ordered = dict[Node, bool](), list[tuple[Node, Node]]()
        self.drops = False
        self.sizes, self._records = list[tuple[Node, float, bool]](), True
        self._upper, self._lower = Bounds(), Bounds()
        for condition, _ in program.exits:
            self._learn(condition, False)
        for condition in missing:
            self._learn(condition, False)
        for condition in holding:
            self._learn(condition, True)
        self.forms = Forms(program, scalar, self.truths, known)
        self._more = 1.0 + 8.0 * self.forms.unit
        for a, b in self._ordered:
            if self._is_number(b):
                self._at_most(a, self._nodes[b][1])
            elif self._is_number(a):
                self._at_least(b, self._nodes[a][1])

    def _learn(self, condition: Node, truth: bool) -> None:
        self.truths[condition] = truth
        match self._nodes[condition]:
            case ("not", inner):
                self._learn(inner, not truth)
            case ("and", a, b) if truth:
                self._learn(a, truth)
                self._learn(b, truth)
            case ("or", a, b) if not truth:
                self._learn(a, truth)
                self._learn(b, truth)
            case ("le" | "lt", a, b) if truth:
                self._ordered.append((a, b))
            case ("ge" | "gt", a, b) if truth:
                self._ordered.append((b, a))
            case ("gt", a, b):  # of numbers: what is NaN is not greater either
                self._ordered.append((a, b))

    def _is_number(self, node: Node) -> bool:
        return bool(self._nodes[node][0] == "const")

    def _factor(self, node: Node) -> tuple[float, Node] | None:
        """The number that a product is with, and the other operand."""
        _, a, b = self._nodes[node]
        if self._is_number(b):
            a, b = b, a
        return (self._nodes[a][1], b) if self._is_number(a) else None

    def _is_zero(self, node: Node) -> bool:
        kind, *operands = self._nodes[node]
        return bool(kind == "sub" and operands[0] == operands[1])

    def _is_positive(self, node: Node) -> bool:
        match self._nodes[node]:
            case ("abs", _):
                return True
            case ("mul", a, b):
                return bool(a == b)
            case ("add", a, b):
                return self._is_positive(a) and self._is_positive(b)
        return False

    def _at_most(self, node: Node, bound: float, drops: bool = False) -> None:
        more = self._more
        match self._nodes[node]:
            case ("add", a, b) if self._is_positive(a) and self._is_positive(b):
                self._at_most(a, bound, drops)  # rounding keeps order
                self._at_most(b, bound, drops)
            case ("add", a, b) if self._is_zero(a) or self._is_zero(b):
                self._at_most(b if self._is_zero(a) else a, bound, drops)
            case ("max", a, b):
                self._at_most(a, bound, True)
                self._at_most(b, bound, True)
            case ("mul", a, b) if a == b:
                self._size(a, bound**0.5 * more, drops)
            case ("mul", _, _) if (found := self._factor(node)) and found[0] > 0.0:
                self._at_most(found[1], bound / found[0] * more, drops)
            case ("abs", a):
                self._size(a, bound, drops)
            case ("neg", a):
                self._at_least(a, -bound, drops)
            case ("sub", a, b) if self._is_number(b):
                by = self._nodes[b][1]
                self._at_most(a, bound + by + (abs(bound) + abs(by)) * (more - 1.0), drops)
            case ("sub", a, b):
                self._upper.setdefault(a, []).append((b, bound, drops))
                self._lower.setdefault(b, []).append((a, -bound, drops))
        self._bound(node, bound, drops, self._upper, self._lower)

    def _at_least(self, node: Node, bound: float, drops: bool = False) -> None:
        match self._nodes[node]:
            case ("min", a, b):
                self._at_least(a, bound, True)
                self._at_least(b, bound, True)
            case ("div", a, b) if self._is_number(a) and bound > 0.0:
                self._records = False  # what a load divides is as large as limits, no miss
                self._at_most(b, self._nodes[a][1] / bound * self._more, drops)
                self._records = True
        self._bound(node, bound, drops, self._lower, self._upper)

    def _size(self, node: Node, bound: float, drops: bool) -> None:
        self._bound(node, bound, drops, self._upper, self._lower)
        self._bound(node, -bound, drops, self._lower, self._upper)

    def _bound(self, node: Node, bound: float, drops: bool, side: Bounds, other: Bounds) -> None:
        """Keep a bound of one side; beside one of the other it is one of the size."""
        side.setdefault(node, []).append((None, bound, drops))
        others = [(abs(by), dropped) for of, by, dropped in other.get(node, []) if of is None]
        if others and self._records:
            by, dropped = min(others)
            self.sizes.append((node, max(abs(bound), by), drops or dropped))

    def least(self, node: Node) -> float:
        """The largest number that a node is known to be no less than."""
        return max((each for other, each, _ in self._lower.get(node, []) if other is None), default=-np.inf)

    def bounds(
        self, node: Node, upper: bool, inside: frozenset[tuple[Node, bool]] = frozenset()
    ) -> list[Form]:
        """Forms that a number is no more than, or no less than."""
        if (node, upper) in inside:
            return []
        if node in self._known:
            return [self._known[node]]
        inside |= {(node, upper)}
        found = self._of_operands(node, upper, inside)
        for other, by, _ in (self._upper if upper else self._lower).get(node, []):
            if other is None:
                found.append(number(by))
            else:
                found += [
                    (x + number(by)).wider(2.0 * self.forms.unit) for x in self.bounds(other, upper, inside)
                ]
        return found[:ALTERNATIVES]

    def _of_operands(self, node: Node, upper: bool, inside: frozenset[tuple[Node, bool]]) -> list[Form]:
        kind, *operands = self._nodes[node]
        match kind:
            case "min" | "max":
                a, b = (self.bounds(each, upper, inside) for each in operands)
                if (kind == "min") == upper:
                    return a + b
                pairs = [(x, y) for x in a for y in b if not (x - y).terms.keys() - {ONE}]
                return [_farther(x, y, upper) for x, y in pairs]
            case "add" | "sub":
                sign = 1.0 if kind == "add" else -1.0
                a = self.bounds(operands[0], upper, inside)
                b = self.bounds(operands[1], upper == (sign > 0.0), inside)
                return [self.forms.sum(x, y, sign) for x in a for y in b][:ALTERNATIVES]
            case "neg":
                return [total((-1.0, x)) for x in self.bounds(operands[0], not upper, inside)]
            case "mul" if made := self._factor(node):
                some = self.bounds(made[1], upper == (made[0] >= 0.0), inside)
                return [self.forms.product(number(made[0]), x) for x in some]
            case "mul":
                return [self.forms.form(node), *self._share_bounds(operands, upper)]
            case "choose" if operands[0] in self.truths:
                return self.bounds(operands[1 if self.truths[operands[0]] else 2], upper, inside)
        return [self.forms.form(node)]

    def _share_bounds(self, operands: list[Node], upper: bool) -> Iterator[Form]:
        """Bounds of s x with s = 1 / max(c x, …): no more than 1 / c."""
        for share, x in (operands, operands[::-1]):
            match self._nodes[share]:
                case ("div", one, load) if self._is_number(one):
                    own, inner, _ = self._multiple(x)
                    for leaf in self._largest(load):
                        factor, of, both = self._multiple(leaf)
                        if of == inner and (both or upper == (factor * own > 0.0)):
                            end = self._nodes[one][1] / abs(factor / own) * self._more
                            yield number(end if upper else -end)

    def _largest(self, node: Node) -> Iterator[Node]:
        kind, *operands = self._nodes[node]
        if kind != "max":
            yield node
        else:
            for each in operands:
                yield from self._largest(each)

    def _multiple(self, node: Node, factor: float = 1.0, sized: bool = False) -> tuple[float, Node, bool]:
        """The factor of a number that is multiplied, that number, and whether its size is taken."""
        match self._nodes[node]:
            case ("abs", a):
                return self._multiple(a, factor, True)
            case ("neg", a):
                return self._multiple(a, -factor, sized)
            case ("mul", _, _) if found := self._factor(node):
                return self._multiple(found[1], factor * found[0], sized)
        return factor, node, sized

    def cut(self, thrust: Node) -> Fact | None:
        """Bound of y - p for y = min(max(p, low), high); None where there is none."""
        self.drops = True
        match self._nodes[thrust]:
            case ("min", inner, high) if self._nodes[inner][0] == "max":
                _, p, low = self._nodes[inner]
            case _:
                return None
        ends = [self._beyond(p, end, upper, thrust) for end, upper in ((high, True), (low, False))]
        if any(each is None for each in ends):
            return None
        error = dict[Product, float]()
        for each in ends:
            assert each is not None
            for m, by in each[1].items():
                error[m] = max(error.get(m, 0.0), by)
        made = self.forms.form(thrust) - self.forms.form(p) + Form({}, error)
        return Fact(made, max(each[0] for each in ends if each is not None))

    def _beyond(
        self, p: Node, end: Node, upper: bool, thrust: Node
    ) -> tuple[float, dict[Product, float]] | None:
        """Largest distance of p beyond an end, as a number and by the sizes of products."""
        found = list[tuple[float, dict[Product, float]]]()
        for x in self.bounds(p, upper):
            over = total((1.0 if upper else -1.0, x), (-1.0 if upper else 1.0, self.forms.form(end)))
            left = {m: abs(value) for m, value in over.terms.items() if m != ONE}
            largest = max([1.0, *(abs(value) for m, value in x.terms.items() if m != ONE)])
            if all(value <= FACTOR * largest for value in left.values()):
                error = {m: over.error.get(m, 0.0) + left.get(m, 0.0) for m in {*over.error, *left}}
                # Where p lies beyond an end, the thrust is that end.
                by = error.pop((end,), 0.0)
                for m in self.forms.form(thrust).terms:
                    error[m] = error.get(m, 0.0) + by
                beyond, size = max(0.0, over.constant), abs(self.forms.form(end).constant)
                if 0.0 < beyond <= ROUNDED * self.forms.unit * size:
                    error[(thrust,)] = error.get((thrust,), 0.0) + beyond / size
                    beyond = 0.0
                found.append((beyond, error))
        return min(found, key=lambda each: each[0], default=None)


def _farther(x: Form, y: Form, upper: bool) -> Form:
    """The larger (upper) or smaller of two forms that differ by a number, with the errors of both."""
    found = x if ((x - y).constant >= 0.0) == upper else y
    error = {m: max(x.error.get(m, 0.0), y.error.get(m, 0.0)) for m in {*x.error, *y.error}}
    return Form(found.terms, error)
