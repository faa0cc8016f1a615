"""A program for several faults, as it is for one of them."""

from dataclasses import replace

from alloc.program.graph import Graph
from alloc.program.nodes import Node, Operation, Program
from alloc.program.order import moved


def at_fault(program: Program, fault: int) -> Program:
    """The program with the numbers of one of its ``faults``, and limits of zero for the thruster that is off.

    To be evaluated and proven; it has no steps to print.
    """
    row, graph = program.faults.index(fault), Graph(program.scalar)
    order: dict[Node, Node] = {}
    for node, operation in enumerate(program.nodes):
        order[node] = _one(graph, moved(operation, order), row, fault)
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
