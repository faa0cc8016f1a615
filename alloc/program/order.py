"""Passes from program to program: order of calculation, and one fault's program out of several.

So few numbers are alive at a time, and fit a processor's registers.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from alloc.program.graph import Graph
from alloc.program.nodes import (
    Branch,
    Exit,
    Node,
    Operation,
    Program,
    Step,
    Write,
    every,
    named,
    operands,
    reachable,
)

Block = tuple[int, ...]
"""Place of a step: the number of each branch around it, from the outside."""


def placed(program: Program) -> Program:
    """The program with each node that C calculates as a step of its own, and without those that none needs.

    Nodes stand in the order of steps. What a branch shares with steps behind it is calculated before it.
    """
    live = set(reachable(program.nodes, program.roots))
    steps = _numbered(_pruned(program.steps, live))
    homes = _homes(program, steps)
    return _renumbered(program, _Placing(program, homes).all(steps))


def _pruned(steps: Iterable[Step], live: set[Node]) -> tuple[Step, ...]:
    kept: list[Step] = []
    for step in steps:
        if isinstance(step, Branch):
            inner = _pruned(step.steps, live)
            merged = tuple(node for node in step.merged if node in live)
            if merged or any(isinstance(each, Exit | Branch) for each in inner):
                kept.append(replace(step, steps=inner, merged=merged))
        elif not isinstance(step, int) or step in live:
            kept.append(step)
    return tuple(kept)


Numbered = list[tuple[Step, Block]]
"""Steps, each with the block that it stands in; a branch with the block of its own steps."""


def _numbered(steps: Iterable[Step], block: Block = ()) -> Numbered:
    return [(step, (*block, at) if isinstance(step, Branch) else block) for at, step in enumerate(steps)]


def _demands(step: Step, block: Block, program: Program) -> list[tuple[Node, Block]]:
    """The nodes that a step itself needs, with the block where it needs them."""
    match step:
        case int():
            return [(step, block)]
        case Exit() | Write():
            return [(node, block) for node in named(step, program)]
        case Branch():
            found = [(step.condition, block[:-1])]
            for node in step.merged:
                _, _, then, other = program.nodes[node]
                found += [(other, block[:-1]), (then, block)]
            for inner, its in _numbered(step.steps, block):
                found += _demands(inner, its, program)
            return found
    return []


def _homes(program: Program, steps: Numbered) -> dict[Node, Block]:
    """The block in which each node is calculated: the innermost around all that need it."""
    taken = every(step for step, _ in steps)
    merged = {node for step in taken if isinstance(step, Branch) for node in step.merged}
    homes: dict[Node, Block] = {program.status: ()}

    def needed(node: Node, block: Block) -> None:
        known = homes.setdefault(node, block)
        same = next((i for i, (a, b) in enumerate(zip(known, block, strict=False)) if a != b), None)
        homes[node] = block[: min(len(known), len(block)) if same is None else same]

    for step, block in steps:
        for node, where in _demands(step, block, program):
            needed(node, where)
    for node in range(len(program.nodes) - 1, -1, -1):  # operands stand before what needs them
        if node in homes and node not in merged:
            for each in operands(program.nodes[node]):
                needed(each, homes[node])
    return homes


class _Placing:
    def __init__(self, program: Program, homes: dict[Node, Block]) -> None:
        self._program, self._homes = program, homes
        self._done: set[Node] = set()
        self._merged: dict[Node, list[Block]] = {}

    def all(self, steps: Numbered) -> tuple[Step, ...]:
        into: list[Step] = []
        self._steps(steps, into, ())
        self._place(self._program.status, into, (), set())
        return tuple(into)

    def _steps(self, steps: Numbered, into: list[Step], here: Block) -> None:
        for step, block in steps:
            if isinstance(step, Write) and not any(isinstance(each, Write) for each in into):
                self._read_all(into)
            demands = _demands(step, block, self._program)
            # What a branch shares with steps outside is calculated before it.
            seen: set[Node] = set()
            for node, _ in demands:
                self._place(node, into, here, seen)
            if isinstance(step, Branch):
                inner: list[Step] = []
                # What an equal branch calculated before, in this block or around it, is there already.
                merged = tuple(node for node in step.merged if not self._known(node, here))
                self._steps(_numbered(step.steps, block), inner, block)
                for node in merged:
                    self._place(self._program.nodes[node][2], inner, block, set())
                    self._merged.setdefault(node, []).append(here)
                self._done.update(merged)
                if merged or any(isinstance(each, Exit | Branch) for each in inner):
                    into.append(replace(step, steps=tuple(inner), merged=merged))
            elif not isinstance(step, int):
                into.append(step)

    def _known(self, node: Node, here: Block) -> bool:
        """True if a branch in this block, or in one around it, has merged the node already."""
        return any(here[: len(block)] == block for block in self._merged.get(node, []))

    def _read_all(self, into: list[Step]) -> None:
        for node, (kind, *_) in enumerate(self._program.nodes):
            if node in self._homes and kind == "input":
                self._place(node, into, (), set())

    def _place(self, node: Node, into: list[Step], here: Block, seen: set[Node]) -> None:
        """Append a node and what it needs, operands first, but for what belongs into a branch further in."""
        if node in self._done or node in seen:
            return
        seen.add(node)
        for each in operands(self._program.nodes[node]):
            self._place(each, into, here, seen)
        home = self._homes[node]
        if home == here[: len(home)]:
            self._done.add(node)
            into.append(node)


def _renumbered(program: Program, steps: tuple[Step, ...]) -> Program:
    order: dict[Node, Node] = {}

    def number(some: Iterable[Step]) -> None:
        for step in some:
            if isinstance(step, int):
                order.setdefault(step, len(order))
            elif isinstance(step, Branch):
                number(step.steps)
                for node in step.merged:
                    order.setdefault(node, len(order))

    number(steps)
    for node in reachable(program.nodes, program.roots):  # conditions of exits, which C prints in parts
        order.setdefault(node, len(order))
    return replace(
        program,
        nodes=tuple(replace_operands(program.nodes[node], order) for node in order),
        exits=tuple((order[condition], status) for condition, status in program.exits),
        outputs={place: order[node] for place, node in program.outputs.items()},
        status=order[program.status],
        names={order[node]: name for node, name in program.names.items() if node in order},
        steps=tuple(_step_moved(step, order) for step in steps),
    )


def replace_operands(operation: Operation, order: Mapping[Node, Node]) -> Operation:
    """An operation whose operands have moved."""
    match operation:
        case ("const" | "by_fault" | "input" | "finite" | "unknown", *_):
            return operation
        case ("loop", name, index, tuple(given)):
            return ("loop", name, index, tuple(order[each] for each in given))
        case (kind, *given):
            return (kind, *(order[each] for each in given if isinstance(each, int)))
    raise AssertionError(operation)


def _step_moved(step: Step, order: dict[Node, Node]) -> Step:
    match step:
        case int():
            return order[step]
        case Exit():
            cases = tuple((order[case], status) for case, status in step.cases)
            return Exit(order[step.condition], cases, step.status, step.unlikely)
        case Branch():
            inner = tuple(_step_moved(each, order) for each in step.steps)
            merged = tuple(order[node] for node in step.merged)
            return Branch(order[step.condition], inner, merged, step.unlikely)
    return step


def at_fault(program: Program, fault: int) -> Program:
    """The program with the numbers of one of its ``faults``, and limits of zero for the thruster that is off.

    To be evaluated and proven; it has no steps to print.
    """
    row, graph = program.faults.index(fault), Graph(program.scalar)
    order: dict[Node, Node] = {}
    for node, operation in enumerate(program.nodes):
        order[node] = _one(graph, replace_operands(operation, order), row, fault)
    return replace(
        program,
        nodes=tuple(graph.nodes),
        exits=tuple((order[condition], status) for condition, status in program.exits),
        outputs={place: order[node] for place, node in program.outputs.items()},
        status=order[program.status],
        names={},
        loops={name: replace(loop, flags=loop.flags[row : row + 1]) for name, loop in program.loops.items()},
        steps=(),
        faults=(),
    )


def _one(graph: Graph, operation: Operation, row: int, fault: int) -> Node:
    match operation:
        case ("by_fault", values):
            return graph.constant(values[row]).node
        case ("input", "f_min" | "f_max", index) if index == fault:
            return graph.constant(0.0).node
        case ("again", inner) if graph.nodes[inner][0] == "const":
            return Node(inner)
        case ("finite", "f_min" | "f_max" as array, first, count) if first <= fault < first + count:
            zero, good = graph.add("const", 0.0), graph.add("const", 1.0)
            for i in range(first, first + count):  # as C looks at them, one after the other, also at the zero
                entry = zero if i == fault else graph.add("input", array, i)
                good = graph.add("and", good, graph.add("eq", graph.add("sub", entry, entry), zero))
            return good
    return graph.add(*operation)
