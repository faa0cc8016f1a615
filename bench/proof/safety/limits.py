"""Limits that are arguments: from what must hold where a call is answered, to f within them.

A kernel answers only where a comparison holds. It holds of no NaN, a sum that is a number has numbers as
terms, a difference of a sum to itself is a number only where the sum is finite, and then zero: so the
comparison says that each f_min[i] - f_max[i] is finite and at most zero, which in IEEE 754 is
f_min[i] <= f_max[i] (subtraction underflows gradually). Last, min(max(x, low), high) lies within low <= high
whatever x is, NaN too.
"""

from math import isfinite

from alloc.program import Node, Program
from bench.proof.subject import ANSWERED

SUMS = ("add", "sub")


def within(program: Program, fault: int, n: int) -> list[str]:
    """The thrusts that aren't shown to lie within f_min and f_max wherever they are written, in words."""
    facts = Known(program)
    for condition, _ in program.exits:
        facts.fails(condition)
    reasons = [
        f"fault {fault}: an answer is returned early" for _, status in program.exits if status in ANSWERED
    ]
    for i in range(n):
        value = program.outputs["f", i]
        if fault == i:
            if not facts.zero(value):
                reasons.append(f"fault {fault}: f[{i}] is not zero")
        elif not facts.clamped(value, i):
            reasons.append(f"fault {fault}: f[{i}] is not shown to lie in f_min[{i}] … f_max[{i}]")
    return reasons


class Known:
    """What is known where a call is answered."""

    def __init__(self, program: Program) -> None:
        """Nothing is known."""
        self._nodes = program.nodes
        self._numbers: set[Node] = set()
        self._finite: set[Node] = set()
        self._ordered: set[tuple[Node, Node]] = set()  # (a, b): a <= b

    def fails(self, condition: Node) -> None:
        """Learn from a condition that does not hold."""
        match self._nodes[condition]:
            case ("not", inner):
                self.holds(inner)
            case ("or", a, b):
                self.fails(a)
                self.fails(b)

    def holds(self, condition: Node) -> None:
        """Learn from a condition that holds."""
        match self._nodes[condition]:
            case ("not", inner):
                self.fails(inner)
            case ("and", a, b):
                self.holds(a)
                self.holds(b)
            case ("le", a, b):
                self._number(a)
                self._number(b)
                self._at_most(a, b)

    def _number(self, node: Node) -> None:
        self._numbers.add(node)
        match self._nodes[node]:
            case ("sub", a, b) if a == b:
                self._is_finite(a)
            case (op, a, b) if op in SUMS:
                self._number(a)
                self._number(b)

    def _is_finite(self, node: Node) -> None:
        self._finite.add(node)
        match self._nodes[node]:
            case (op, a, b) if op in (*SUMS, "mul"):
                self._is_finite(a)
                self._is_finite(b)
            case ("neg" | "abs", a):
                self._is_finite(a)

    def _at_most(self, node: Node, bound: Node) -> None:
        """Learn from node <= bound, both numbers."""
        self._ordered.add((node, bound))
        match self._nodes[node]:
            case ("add", a, b) if self._zero(b):
                self._at_most(a, bound)
            case ("add", a, b) if self._zero(a):
                self._at_most(b, bound)
            case ("max", a, b):  # an operand that is NaN leaves what is known of the other one as it is
                for each in (a, b):
                    if self._known(each):
                        self._at_most(each, bound)
            case ("sub", a, b) if self._nodes[bound] == ("const", 0.0) and {a, b} <= self._finite:
                self._ordered.add((a, b))

    def _zero(self, node: Node) -> bool:
        match self._nodes[node]:
            case ("sub", a, b):
                return bool(a == b and a in self._finite)
        return False

    def _known(self, node: Node) -> bool:
        """Whether the node is a number, infinite perhaps."""
        if node in self._finite or node in self._numbers:
            return True
        match self._nodes[node]:
            case ("max" | "min", a, b):
                return self._known(a) and self._known(b)
            case ("neg" | "abs", a):
                return self._known(a)
            case ("mul", a, b):
                return self._certain(a) and self._certain(b)
            case ("add" | "sub", a, b):
                return (self._certain(a) and self._known(b)) or (self._known(a) and self._certain(b))
        return self._certain(node)

    def _certain(self, node: Node) -> bool:
        """Whether the node is known to be finite."""
        return node in self._finite or (self._nodes[node][0] == "const" and isfinite(self._nodes[node][1]))

    def zero(self, value: Node) -> bool:
        """Whether a value is zero: the constant, or min(max(x, 0), 0), whatever x is."""
        match self._nodes[value]:
            case ("min", inner, high) if self._nodes[high] == ("const", 0.0):
                match self._nodes[inner]:
                    case ("max", _, low):
                        return self._nodes[low] == ("const", 0.0)
        return self._nodes[value] == ("const", 0.0)

    def clamped(self, value: Node, i: int) -> bool:
        """Whether a value is min(max(x, f_min[i]), f_max[i]) with limits that are known not to cross."""
        match self._nodes[value]:
            case ("min", inner, high) if self._nodes[high] == ("input", "f_max", i):
                match self._nodes[inner]:
                    case ("max", _, low) if self._nodes[low] == ("input", "f_min", i):
                        return (low, high) in self._ordered
        return False
