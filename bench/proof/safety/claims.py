"""The claims about memory, status and limits.

Frama-C shows that thrusts lie inside the vehicle's limits. Limits that are arguments need reasoning of our
own, from what must hold where a call is answered. It is answered only where a comparison holds. It holds of
no NaN, a sum that is a number has numbers as terms, a difference of a sum to itself is a number only where
the sum is finite, and then zero: so the comparison says that each f_min[i] - f_max[i] is finite and at most
zero, which in IEEE 754 is f_min[i] <= f_max[i] (subtraction underflows gradually). Last,
min(max(x, low), high) lies within low <= high whatever x is, NaN too.

A thruster that is off of many in one function has x - 1 (0 y + 1 x): all finite, it is zero, which the
limits leave as it is.
"""

from collections.abc import Callable
from functools import partial
from math import isfinite
from pathlib import Path

from alloc.program import Node, Program
from bench.chips.toolchain import ToolError
from bench.proof import tools
from bench.proof.proof import Claim
from bench.proof.safety import eva
from bench.proof.safety.harness import harness
from bench.proof.source import (
    ANSWERED,
    NotRead,
    Subject,
    of_all_branches,
    of_one_branch,
    read,
    static_variables,
)
from bench.proof.symbolic import programs

SUMS = ("add", "sub")
OWN = "the comparison that answers (bench/proof/safety/claims.py)"
WRITTEN = ("status", "written_f", "written_share", "untouched_f", "untouched_share")
OFF = "off"
WITHIN = ("number_f", "low", "high", OFF)
SHARED = ("number_share", "share_share")
HARNESS = {*WRITTEN, *WITHIN, *SHARED}
"""Labels of the harness's assertions; what EVA decides beside them is about run-time errors."""

NO_ERROR = (
    "No run-time error: no access outside of an array, no overflow of an integer, no division by an integer"
    " zero, no read of what was never written; for every fault index and all bits of tau and limits."
)
STATUS = (
    "The status is one that the header names; f and share are written whole, or, where it is none of an"
    " answer, not touched."
)
LIMITS = (
    "Where f is written, every thrust is a number within the limits, and that of a thruster that is off is"
    " zero."
)
STATELESS = "An answer depends on its call's arguments alone: no data that can change outlive a call."
SHARES = "Every share is a number from 0 to 1."


def claims(of: Subject, folder: Path) -> list[Claim]:
    """Claims shown of the kernel, with any bits in its arguments; raises NotInstalled without Frama-C."""
    tools.need("frama-c")
    try:
        analysis = eva.analyse(harness(of), folder, *_functions(of))
    except (NotRead, ToolError) as reason:
        analysis = eva.Analysis([], False, [str(reason)])
    made = [
        eva.claim(NO_ERROR, analysis, *analysis.alarms(*HARNESS)),
        eva.claim(STATUS, analysis, *WRITTEN),
    ]
    if not of.limited:
        made.append(
            Claim(claim=LIMITS, verdict="does not apply", by="", words=["this method knows no limits"])
        )
    elif of.limits == "fixed":
        made.append(_fixed(of, analysis))
    else:
        made.append(_by_operations(of, OWN, partial(limit_gaps, n=of.vehicle.n)))
    if of.levels:
        made.append(eva.claim(SHARES, analysis, *SHARED))
    return of_all_branches([*made, _stateless(of)], of)


def _functions(of: Subject) -> tuple[set[str], set[str]]:
    """Names of the functions that return a status, and of those whose loops data end."""
    try:
        unit = of_one_branch(of)  # the analyser reads the same
    except (NotRead, ToolError):
        return set(), set()  # EVA says what is wrong with it
    return {of.name, *unit.answering}, unit.looping


def _stateless(of: Subject) -> Claim:
    return stateless(STATELESS, lambda: static_variables(read(of).text))


def stateless(claim: str, found: Callable[[], set[str]]) -> Claim:
    """The claim that no variable of some C, as those ``found``, is kept from one call to the next."""
    try:
        words = [f"{name} outlives a call, and can change" for name in sorted(found())]
    except (NotRead, ToolError) as reason:
        words = [str(reason)]
    return Claim(claim=claim, verdict="not shown" if words else "shown", by="the C, read", words=words)


def _fixed(of: Subject, analysis: eva.Analysis) -> Claim:
    """Intervals lose the zero of x - x: where EVA shows all but that, the operations may."""
    beside = eva.claim(LIMITS, analysis, *(label for label in WITHIN if label != OFF))
    if beside.verdict == "not shown" or not analysis.failed(OFF):
        return eva.claim(LIMITS, analysis, *WITHIN)
    return _by_operations(of, f"{eva.NAME}; that of a thruster that is off: {OWN}", rest_gaps)


def _by_operations(of: Subject, by: str, unshown: Callable[[Program, int], list[str]]) -> Claim:
    """The claim on limits from the operations of each fault, of which ``unshown`` says what is missing."""
    try:
        words = [text for fault, program in programs(of).items() for text in unshown(program, fault)]
    except (NotRead, ToolError) as reason:
        words = [str(reason)]
    return Claim(claim=LIMITS, verdict="not shown" if words else "shown", by=by, words=words)


def limit_gaps(program: Program, fault: int, n: int) -> list[str]:
    """The thrusts that aren't shown to lie within f_min and f_max wherever they are written, in words."""
    facts = AnsweredFacts(program)
    return rest_gaps(program, fault) + [
        f"fault {fault}: f[{i}] is not shown to lie in f_min[{i}] … f_max[{i}]"
        for i in range(n)
        if i != fault and not facts.clamped(program.outputs["f", i], i)
    ]


def rest_gaps(program: Program, fault: int) -> list[str]:
    """Reason why the thruster that is off isn't shown to have zero wherever f is written, in words."""
    reasons = [
        f"fault {fault}: an answer is returned early" for _, status in program.exits if status in ANSWERED
    ]
    if fault >= 0 and not AnsweredFacts(program).zero(program.outputs["f", fault]):
        reasons.append(f"fault {fault}: f[{fault}] is not zero")
    return reasons


class AnsweredFacts:
    """AnsweredFacts known where a call is answered."""

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
