"""Nodes of a program: operations, exits, writes."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from typing import Any, Literal

Scalar = Literal["double", "float"]
"""The type of all numbers of a program, by C's name."""
Where = Literal["fixed", "call"]
"""Place of the limits: the vehicle's own in the kernel, or f_min and f_max as arguments of each call."""
Faults = Literal["none", "one", "all"]
"""Faults that a C function knows: none, any one thruster off with code for each, or the same in one code."""
OWN = "OWN_"
"""Prefix in C text of each name that only one file may see; a printer puts its function's there."""
Node = int
"""Index of an operation in ``Program.nodes``."""
Operation = tuple[Any, ...]
"""Name of an operation, then its operands, which stand before it in ``Program.nodes``.

("const", 1.5), ("input", "tau", 0)
    a number; an entry of an argument
("by_fault", (1.5, 2.5, …))
    a number that each fault has its own of, in the order of ``Program.faults``
("add", a, b), ("sub", a, b), ("mul", a, b), ("div", a, b), ("neg", a), ("abs", a)
    arithmetic, rounded to the scalar after each operation
("min", a, b), ("max", a, b)
    C's a < b ? a : b and a > b ? a : b, so that b stands where a is NaN. Where b is NaN a comparison gives b
    and an FPU's own instruction gives a; no answer may depend on that.
("lt", a, b), ("le", a, b), ("gt", a, b), ("ge", a, b), ("eq", a, b), ("ne", a, b)
    conditions; but for ``ne`` none holds of NaN
("and", a, b), ("or", a, b), ("not", a)
    conditions of conditions
("finite", "tau", first, count)
    the condition that these entries of an argument are numbers and not infinite
("choose", condition, a, b)
    a where the condition holds, else b
("again", input)
    the same entry of an argument, read anew, so that it holds no register until then
("loop", name, index, (a, b, …))
    entry ``index`` of what a loop over data makes of its operands: see ``DataLoop``
("unknown", number)
    a number that nothing is known about
"""


@dataclass(frozen=True)
class DataLoop:
    """A loop over data, which stays C text: its function takes arrays and changes the last one in place.

    Attributes
    ----------
    name : of the C function behind OWN, and of the node
    text : the C of ``static void OWN_name(…)`` and of what it needs, whose names begin with OWN too
    arrays : name and size of each array it takes, in their order
    flags : integers that it takes before the last array, as of which thrusters work; of each fault, or of all
    """

    name: str
    text: str
    arrays: tuple[tuple[str, int], ...]
    flags: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True)
class Fence:
    """Scheduling barrier; limits register pressure."""


@dataclass(frozen=True)
class Exit:
    """A return where ``condition`` holds, of the first status whose own condition holds, else of the last.

    ``unlikely`` tells the compiler to jump there, so that other calls go straight on.
    """

    condition: Node
    cases: tuple[tuple[Node, int], ...]
    status: int
    unlikely: bool = True


@dataclass(frozen=True)
class Branch:
    """Steps that are taken where ``condition`` holds; behind them stand the ``merged`` nodes (``choose``).

    ``unlikely`` tells the compiler to jump there, so that other calls go straight on.
    """

    condition: Node
    steps: "tuple[Step, ...]"
    merged: tuple[Node, ...]
    unlikely: bool = False


@dataclass(frozen=True)
class Write:
    """An output is written; every argument was read before the first, as they may be the same array."""

    array: str
    index: int


Step = Node | Fence | Exit | Branch | Write
"""Next step of a printer; a node stands for its being calculated, and all that it needs before it."""


def every(steps: Iterable[Step]) -> Iterator[Step]:
    """All steps, those of a branch behind it."""
    for step in steps:
        yield step
        if isinstance(step, Branch):
            yield from every(step.steps)


@dataclass(frozen=True, eq=False, kw_only=True)
class Program:
    """One kernel for one state of the thrusters.

    Attributes
    ----------
    nodes : the operations, equal ones once, operands first
    exits : conditions, each with the status that is returned where it holds, unless one before it held;
        then nothing is written
    outputs : array and index, as ("f", 0) or ("share", 0), to what is written there
    status : what is returned behind that, a node of numbers
    scalar : the type of all numbers
    names : what nodes are called in C, of those that have a name
    steps : in which order a printer calculates; only counts of instructions depend on it
    loops : by name, the loops that nodes belong to
    faults : of a program for several faults, which these are, -1 for none; see ``at_fault``
    """

    nodes: tuple[Operation, ...]
    exits: tuple[tuple[Node, int], ...]
    outputs: Mapping[tuple[str, int], Node]
    status: Node
    scalar: Scalar = "double"
    names: Mapping[Node, str] = field(default_factory=dict)
    steps: tuple[Step, ...] = ()
    loops: Mapping[str, DataLoop] = field(default_factory=dict)
    faults: tuple[int, ...] = ()

    @cached_property
    def straight(self) -> bool:
        """True if nearly all calls take the same steps, so that demands can be answered side by side."""
        branches = [step for step in self.steps if isinstance(step, Branch)]
        return not self.loops and all(step.unlikely for step in branches)

    @cached_property
    def roots(self) -> tuple[Node, ...]:
        """Nodes that the answer depends on."""
        return (*(condition for condition, _ in self.exits), *self.outputs.values(), self.status)

    @cached_property
    def statuses(self) -> frozenset[int]:
        """All that it may return."""
        found = {status for _, status in self.exits}
        waiting = [self.status]
        while waiting:
            match self.nodes[waiting.pop()]:
                case ("const", value):
                    found.add(int(value))
                case ("choose", _, a, b):
                    waiting += [a, b]
        return frozenset(found)

    def size(self, array: str) -> int:
        """Number of an output's entries."""
        return sum(name == array for name, _ in self.outputs)


def named(step: Step, program: Program) -> tuple[Node, ...]:
    """The nodes that a step itself asks for, those of a branch's own steps left out."""
    match step:
        case int():
            return operands(program.nodes[step])
        case Exit():
            return (step.condition, *(case for case, _ in step.cases))
        case Write():
            return (program.outputs[step.array, step.index],)
        case Branch():
            ends = (operands(program.nodes[node])[1:] for node in step.merged)
            return (step.condition, *chain.from_iterable(ends))
    return ()


def operands(operation: Operation) -> tuple[Node, ...]:
    """The nodes that an operation needs."""
    match operation:
        case ("const" | "by_fault" | "input" | "finite" | "unknown", *_):
            return ()
        case ("loop", _, _, needed):
            return tuple(needed)
    return operation[1:]


def reachable(nodes: tuple[Operation, ...], roots: tuple[Node, ...]) -> Iterator[Node]:
    """The nodes that these need, themselves among them, each once and behind its operands."""
    seen: set[Node] = set()
    waiting = [(node, False) for node in reversed(roots)]
    while waiting:
        node, ready = waiting.pop()
        if ready:
            yield node
        elif node not in seen:
            seen.add(node)
            waiting.append((node, True))
            waiting += [(each, False) for each in reversed(operands(nodes[node])) if each not in seen]
