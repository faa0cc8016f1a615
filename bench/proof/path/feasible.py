"""Whether any arguments take a way through a binary: a question to an SMT solver, z3.

Each number is a real one and a flag that says NaN; infinity is what lies beyond the largest finite number.
That keeps the order of all numbers, so how comparisons, minimum, maximum, sign and choice hang together is
exact. Of arithmetic only facts go in that hold whatever was rounded: a finite sum is that of its operands but
for half a unit in the last place, a product has its operands' sign. So "no" is a proof; "perhaps" is not.
"""

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.proof.path.cases import ByOutcome, Integer, combined, compares
from bench.proof.path.numbers import Numbers


class Feasibility:
    """Questions about the numbers of one kernel with one fault."""

    def __init__(
        self, numbers: Numbers, rounds: bool = True, apart: float = 0.0, overflow: bool = True
    ) -> None:
        """Nothing is known yet.

        With ``rounds`` off arithmetic is that of real numbers, and numbers that compare as less or greater
        lie so far ``apart``: where conditions hold that way, they likely do in the binary. With ``overflow``
        off nothing is known of when a sum or a product is infinite, which is answered sooner.
        """
        import z3

        self._z3, self._numbers = z3, numbers
        facts = np.finfo(numbers.scalar)
        self.rounds, self.apart, self._overflow = rounds, apart, overflow
        self._half = z3.Q(int(rounds), 2 ** (facts.nmant + 1))
        self._tiniest = _exactly(z3, int(rounds) * Fraction(float(facts.smallest_subnormal)) / 2)
        self._apart = _exactly(z3, Fraction(apart))
        beyond = 2 ** (1 << (facts.nexp - 1))
        self._beyond = z3.RealVal(beyond)
        self._largest = _exactly(z3, Fraction(float(facts.max)))
        self._overflows = z3.RealVal(beyond - beyond // 2 ** (facts.nmant + 2))
        self._known: dict[int, list[Any]] = {}
        self._reals: dict[int, Any] = {}
        self._nans: dict[int, Any] = {}

    def possible(self, held: Iterable[tuple[Integer, bool]], effort: int) -> bool | NDArray[Any]:
        """Whether conditions may hold together: False, True, or inputs (k,) for which they may.

        z3 may spend so much ``effort`` on it, in its own measure, which is the same on each machine.
        """
        z3 = self._z3
        solver = z3.SolverFor("QF_LRA")
        solver.set("rlimit", effort)
        held = list(held)
        cone = self._cone(each for each, _ in held)
        for node in cone:
            solver.add(*self._facts(node))
        for each, wanted in held:
            solver.add(self.condition(each if wanted else combined(lambda x: int(not x), each)))
        answer = solver.check()
        if answer == z3.unsat:
            return False
        return True if answer == z3.unknown else self._inputs(solver.model())

    def _cone(self, conditions: Iterable[Integer]) -> list[int]:
        """The numbers that conditions are made of, operands first."""
        found: set[int] = set()
        waiting = [each for condition in conditions for each in self._asked(condition)]
        while waiting:
            node = waiting.pop()
            if node in found:
                continue
            found.add(node)
            match self._numbers.made[node]:
                case ("const", _) | ("input", _, _):
                    pass
                case ("choose", condition, a, b):
                    waiting += [a, b, *self._asked(condition)]
                case (_, *operands):
                    waiting += operands
        return sorted(found)

    def _asked(self, condition: Integer) -> set[int]:
        return {node for each in compares(condition) for node in self._numbers.compared[each]}

    def condition(self, integer: Integer) -> Any:
        """The formula that says an integer is not zero."""
        z3 = self._z3
        if not isinstance(integer, ByOutcome):
            return z3.BoolVal(bool(integer))
        if integer.leaves[0] == integer.leaves[1] == integer.leaves[2] == integer.leaves[3]:
            return self.condition(integer.leaves[0])
        a, b = self._numbers.compared[integer.compare]
        x, y = self._reals[a], self._reals[b]
        less, equal, greater, unordered = (self.condition(leaf) for leaf in integer.leaves)
        nan = z3.Or(self._nans[a], self._nans[b])
        return z3.Or(
            z3.And(nan, unordered),
            z3.And(z3.Not(nan), x < y - self._apart, less),
            z3.And(z3.Not(nan), x == y, equal),
            z3.And(z3.Not(nan), x > y + self._apart, greater),
        )

    def _inputs(self, model: Any) -> NDArray[Any]:
        found = []
        for node, operation in enumerate(self._numbers.made):
            if operation[0] == "input":
                if node not in self._reals:
                    found.append(0.0)
                    continue
                if self._z3.is_true(model.eval(self._nans[node])):
                    found.append(np.nan)
                    continue
                value = model.eval(self._reals[node], model_completion=True)
                fraction = Fraction(value.numerator_as_long(), value.denominator_as_long())
                found.append(float(max(-_LARGE, min(_LARGE, fraction))))
        return np.array(found)

    def _facts(self, node: int) -> list[Any]:
        """What is known of a number whose operands were asked for before."""
        if node not in self._known:
            self._reals[node] = self._z3.Real(f"r{node}")
            self._nans[node] = self._z3.Bool(f"n{node}")
            self._known[node] = self._made(node, *self._numbers.made[node])
        return self._known[node]

    def _finite(self, node: int) -> Any:
        x = self._reals[node]
        return self._z3.And(self._z3.Not(self._nans[node]), x <= self._largest, x >= -self._largest)

    def _bounded(self, node: int) -> Any:
        """That a number is finite, or one of the two that stand for infinity."""
        z3, x = self._z3, self._reals[node]
        return z3.Or(z3.And(x <= self._largest, x >= -self._largest), x == self._beyond, x == -self._beyond)

    def _made(self, node: int, operation: str, *operands: Any) -> list[Any]:
        z3 = self._z3
        s, nan = self._reals[node], self._nans[node]
        if operation == "input":
            return [self._bounded(node)]
        if operation == "const":
            if np.isnan(operands[0]):
                return [nan]
            infinite = not np.isfinite(operands[0])
            size = (
                self._beyond * int(np.sign(operands[0])) if infinite else _exactly(z3, Fraction(operands[0]))
            )
            return [z3.Not(nan), s == size]
        if operation == "choose":
            condition, a, b = operands
            held = self.condition(condition)
            return [
                s == z3.If(held, self._reals[a], self._reals[b]),
                nan == z3.If(held, self._nans[a], self._nans[b]),
            ]
        values = [self._reals[each] for each in operands]
        nans = [self._nans[each] for each in operands]
        match operation, values:
            case "neg", [a]:
                return [s == -a, nan == nans[0]]
            case "abs", [a]:
                return [s == z3.If(a < 0, -a, a), nan == nans[0]]
            case "min" | "max", [a, b]:
                first = a < b if operation == "min" else a > b
                chosen = z3.If(nans[0], b, z3.If(nans[1], a, z3.If(first, a, b)))
                return [s == chosen, nan == z3.And(*nans)]
        return [
            z3.Implies(z3.Or(*nans), nan),
            *self._rounded(node, operation, [int(each) for each in operands]),
        ]

    def _rounded(self, node: int, operation: str, operands: list[int]) -> list[Any]:
        z3 = self._z3
        s, nan, nans = self._reals[node], self._nans[node], [self._nans[each] for each in operands]
        if operation not in ("add", "sub", "mul", "div"):
            return []
        (a, b), known = (self._reals[each] for each in operands), [self._finite(each) for each in operands]
        made = self._numbers.made
        finite = self._finite(node)
        if operation in ("add", "sub"):
            total = a + b if operation == "add" else a - b
            against = [z3.Not(each) for each in known] + [total == 0]  # infinite, and of opposite effect
            return [  # gradual underflow: a sum is zero only where it is
                nan == z3.Or(*nans, z3.And(*against))
                if self._overflow
                else z3.Implies(nan, z3.Or(*nans, z3.Not(z3.Or(*known)))),
                self._value(node, total, z3.And(*known), z3.RealVal(0)),
                z3.Implies(z3.Not(nan), z3.And((s > 0) == (total > 0), (s < 0) == (total < 0))),
            ]
        constant = [each for each in operands if made[each][0] == "const" and np.isfinite(made[each][1])]
        if operation == "mul" and constant:
            factor, other = made[constant[0]][1], operands[operands[0] == constant[0]]
            product = _exactly(z3, Fraction(factor)) * self._reals[other]
            return [
                self._value(node, product, self._finite(other), self._tiniest)
                if factor
                else z3.Implies(finite, z3.And(self._finite(other), s == 0)),
                z3.Implies(
                    z3.Not(nan), z3.And(z3.Implies(s > 0, product > 0), z3.Implies(s < 0, product < 0))
                ),
                *([nan == self._nans[other]] if factor else []),
            ]
        same = z3.Or(z3.And(a >= 0, b >= 0), z3.And(a <= 0, b <= 0))
        opposed = z3.Or(z3.And(a >= 0, b <= 0), z3.And(a <= 0, b >= 0))
        signs = [z3.Implies(same, s >= 0), z3.Implies(opposed, s <= 0)]
        x, y, size = (z3.If(each < 0, -each, each) for each in (a, b, s))
        if operation == "mul":
            sizes = [z3.Implies(x <= 1, size <= y), z3.Implies(y <= 1, size <= x)]
            sizes += [z3.Implies(x >= 1, size >= y), z3.Implies(y >= 1, size >= x)]
            return [
                z3.Implies(z3.Not(nan), z3.And(*signs, *sizes)),
                z3.Implies(finite, z3.And(*known)),
                z3.Implies(nan, z3.Or(*nans, z3.Not(z3.And(*known)))),
            ]
        sizes = [z3.Implies(z3.And(x <= y, y > 0), size <= 1), z3.Implies(x >= y, size >= 1)]
        return [
            z3.Implies(z3.And(z3.Not(nan), b != 0), z3.And(*signs[:2])),
            z3.Implies(z3.Not(nan), z3.And(*sizes)),
            z3.Implies(finite, known[0]),
            z3.Implies(nan, z3.Or(*nans, z3.Not(z3.Or(*known)), z3.And(a == 0, b == 0))),
        ]

    def _value(self, node: int, exact: Any, finite: Any, more: Any) -> Any:
        """What a number is whose operands give an ``exact`` value, where both are ``finite``."""
        z3, s, own = self._z3, self._reals[node], self._finite(node)
        near = self._near(s, exact, more)
        if not self._overflow:
            return z3.Implies(own, z3.And(finite, near))
        infinite = s == z3.If(exact > 0, self._beyond, -self._beyond)
        fits = z3.And(finite, exact < self._overflows, exact > -self._overflows)
        return z3.Implies(z3.Not(self._nans[node]), z3.If(fits, z3.And(own, near), infinite))

    def _near(self, s: Any, exact: Any, more: Any) -> Any:
        """That s is an exact value rounded."""
        z3 = self._z3
        room = self._half * z3.If(exact < 0, -exact, exact) + more
        return z3.And(s - exact <= room, exact - s <= room)


_LARGE = Fraction(10**300)


def _exactly(z3: Any, value: Fraction) -> Any:
    return z3.Q(value.numerator, value.denominator)
