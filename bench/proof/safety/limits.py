"""From what must hold where a call is answered, to f within limits that are arguments, and zero if off.

A kernel answers only where a comparison holds. It holds of no NaN, a sum that is a number has numbers as
terms, a difference of a sum to itself is a number only where the sum is finite, and then zero: so the
comparison says that each f_min[i] - f_max[i] is finite and at most zero, which in IEEE 754 is
f_min[i] <= f_max[i] (subtraction underflows gradually). Last, min(max(x, low), high) lies within low <= high
whatever x is, NaN too.

A thruster that is off of many in one function has x - 1 (0 y + 1 x): all finite, it is zero, which the
limits leave as it is.
"""

from math import isfinite

from alloc.program import Node, Program
from bench.proof.subject import ANSWERED

SUMS = ("add", "sub")


def within(program: Program, fault: int, n: int) -> list[str]:
    """The thrusts that aren't shown to lie within f_min and f_max wherever they are written, in words."""
    facts = Known(program)
    return resting(program, fault) + [
        f"fault {fault}: f[{i}] is not shown to lie in f_min[{i}] … f_max[{i}]"
        for i in range(n)
        if i != fault and not facts.clamped(program.outputs["f", i], i)
    ]


def resting(program: Program, fault: int) -> list[str]:
    """Reason why the thruster that is off isn't shown to have zero wherever f is written, in words."""
    reasons = [
        f"fault {fault}: an answer is returned early" for _, status in program.exits if status in ANSWERED
    ]
    if fault >= 0 and not Known(program).zero(program.outputs["f", fault]):
        reasons.append(f"fault {fault}: f[{fault}] is not zero")
    return reasons


class Known:
    """Facts known where a call is answered."""

    def __init__(self, program: Program) -> None:
        """Start from the fact that no condition of an exit held."""
        self._nodes = program.nodes
        self._numbers: set[Node] = set()
        self._finite: set[Node] = set()
        self._ordered: set[tuple[Node, Node]] = set()  # (a, b): a <= b
        for condition, _ in program.exits:
            self.fails(condition)

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
        """True if the node is a number, infinite perhaps."""
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
        """True if the node is known to be finite."""
        match self._nodes[node]:
            case ("const", value):
                return isfinite(value)
            case ("div", a, b):
                return self._certain(a) and self._at_least_one(b)
        return node in self._finite

    def _at_least_one(self, node: Node) -> bool:
        """True if the node is a number of one or more: of a maximum the last operand, if others are NaN."""
        match self._nodes[node]:
            case ("const", value):
                return bool(value >= 1.0)
            case ("max", _, last):
                return self._at_least_one(last)
        return False

    def zero(self, value: Node) -> bool:
        """True if a value is zero: min(max(x, 0), 0), whatever x is, or zero within constant limits."""
        match self._nodes[value]:
            case ("min", inner, high):
                match self._nodes[inner], self._nodes[high]:
                    case ("max", x, low), ("const", most) if self._nodes[low][0] == "const":
                        least = self._nodes[low][1]
                        return bool(least == most == 0.0 or (least <= 0.0 <= most and self.zero(x)))
            case ("const", number):
                return bool(number == 0.0)
            case ("mul", a, b):
                return (self.zero(a) and self._certain(b)) or (self._certain(a) and self.zero(b))
            case ("add", a, b):
                return self.zero(a) and self.zero(b)
            case ("sub", a, b):
                return self._alone(a) == self._alone(b) and self._certain(self._alone(a))
        return False

    def _alone(self, node: Node) -> Node:
        """The node that this one equals: times one, and beside zeros, it is left as it is."""
        match self._nodes[node]:
            case ("mul", a, b) if self._nodes[a] == ("const", 1.0):
                return self._alone(b)
            case ("add", a, b) if self.zero(b):
                return self._alone(a)
            case ("add", a, b) if self.zero(a):
                return self._alone(b)
        return node

    def clamped(self, value: Node, i: int) -> bool:
        """True if a value is min(max(x, f_min[i]), f_max[i]) with limits that are known not to cross."""
        match self._nodes[value]:
            case ("min", inner, high) if self._nodes[high] == ("input", "f_max", i):
                match self._nodes[inner]:
                    case ("max", _, low) if self._nodes[low] == ("input", "f_min", i):
                        return (low, high) in self._ordered
        return False
