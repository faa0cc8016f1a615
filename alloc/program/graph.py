"""Values with operators, which make the nodes of a program; equal nodes are made once."""

import operator
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from alloc.program.nodes import Node, Operation, Scalar

FOLDED: dict[str, Callable[..., float]] = {
    "add": operator.add, "sub": operator.sub, "mul": operator.mul, "div": operator.truediv,
    "neg": operator.neg, "abs": abs, "min": min, "max": max,
}  # fmt: skip
"""Operations that are calculated beforehand where their operands are known for each fault."""


class Graph:
    """Operations in the order in which they are made.

    Attributes
    ----------
    nodes : the operations
    names : what some of them are called in C
    scalar : the type that constants are rounded to
    """

    def __init__(self, scalar: Scalar = "double") -> None:
        """Without a node."""
        self.scalar = scalar
        self.nodes: list[Operation] = []
        self.names: dict[Node, str] = {}
        self._known: dict[tuple[str, Operation], Node] = {}

    def add(self, *operation: Any) -> Node:
        """The node of an operation, an old one where there is an equal one."""
        # Zero and its opposite are equal to Python, and two numbers to C.
        key = (repr(operation[1]) if operation[0] in ("const", "by_fault") else "", operation)
        node = self._known.setdefault(key, len(self.nodes))
        if node == len(self.nodes):
            self.nodes.append(operation)
        return node

    def value(self, *operation: Any) -> "Expression":
        """The same as a value; of numbers that are known for each fault it is calculated now."""
        if operation[0] in FOLDED:
            rows = [self.fixed_values(node) for node in operation[1:]]
            if all(rows):
                wide = max(map(len, rows))
                columns = zip(*(row if len(row) > 1 else row * wide for row in rows), strict=True)
                return self.by_fault([FOLDED[operation[0]](*column) for column in columns])
        return Expression(self, self.add(*operation))

    def constant(self, number: float) -> "Expression":
        """A number, rounded to the scalar."""
        return self.value("const", float(np.float32(number)) if self.scalar == "float" else float(number))

    def by_fault(self, numbers: Iterable[float]) -> "Expression":
        """One constant a fault, or a single constant where all are equal; not rounded yet."""
        first, *others = values = tuple(map(float, numbers))
        if all(each == first for each in others):
            return self.constant(first)
        return self.value("by_fault", values)

    def of_each(self, numbers: Iterable[float]) -> "Number":
        """The same, but a plain number where all faults have one."""
        return self.plain(self.by_fault(numbers))

    def plain(self, number: "Number") -> "Number":
        """The number itself where it is one that is known, and the same for all faults."""
        each = self.fixed_values(number.node) if isinstance(number, Expression) else ()
        return each[0] if len(each) == 1 else number

    def fixed_values(self, node: Node) -> tuple[float, ...]:
        """The number of each fault, or the one of all; empty where it is not known beforehand."""
        match self.nodes[node]:
            case ("const", value):
                return (value,)
            case ("by_fault", values):
                return tuple(values)
        return ()


class Expression:
    """A node, with operators that make others. Python's == tells whether two are the same node."""

    __slots__ = ("graph", "node")

    def __init__(self, graph: Graph, node: Node) -> None:
        """Wrap a node of a graph."""
        self.graph, self.node = graph, node

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and self.node == other.node

    def __hash__(self) -> int:
        return hash(self.node)

    def named(self, name: str) -> "Expression":
        """The same, with a name in C unless it is a number or has one."""
        if self.graph.nodes[self.node][0] not in ("const", "by_fault"):
            self.graph.names.setdefault(self.node, name)
        return self

    def _made(self, kind: str, *others: "Expression | float") -> "Expression":
        return self.graph.value(kind, *(lifted(each, self.graph).node for each in (self, *others)))

    def __add__(self, other: "Expression | float") -> "Expression":
        return self._made("add", other)

    def __radd__(self, other: float) -> "Expression":
        return lifted(other, self.graph) + self

    def __sub__(self, other: "Expression | float") -> "Expression":
        return self._made("sub", other)

    def __rsub__(self, other: float) -> "Expression":
        return lifted(other, self.graph) - self

    def __mul__(self, other: "Expression | float") -> "Expression":
        return self._made("mul", other)

    def __rmul__(self, other: float) -> "Expression":
        return self if other == 1.0 else lifted(other, self.graph) * self

    def __truediv__(self, other: "Expression | float") -> "Expression":
        return self._made("div", other)

    def __rtruediv__(self, other: float) -> "Expression":
        return lifted(other, self.graph) / self

    def __neg__(self) -> "Expression":
        return self._made("neg")

    def __lt__(self, other: "Expression | float") -> "Expression":
        return self._made("lt", other)

    def __le__(self, other: "Expression | float") -> "Expression":
        return self._made("le", other)

    def __gt__(self, other: "Expression | float") -> "Expression":
        return self._made("gt", other)

    def __ge__(self, other: "Expression | float") -> "Expression":
        return self._made("ge", other)

    def equals(self, other: "Expression | float") -> "Expression":
        """The condition that both are the same number."""
        return self._made("eq", other)

    def differs(self, other: "Expression | float") -> "Expression":
        """The opposite."""
        return self._made("ne", other)

    def __and__(self, other: "Expression") -> "Expression":
        return self._made("and", other)

    def __or__(self, other: "Expression") -> "Expression":
        return self._made("or", other)

    def __invert__(self) -> "Expression":
        return self._made("not")


Number = Expression | float
"""A node, or what is known beforehand; operations on two known numbers are Python's."""


def lifted(number: Number, graph: Graph) -> Expression:
    """A number as a value."""
    return number if isinstance(number, Expression) else graph.constant(number)


def size(value: Expression) -> Expression:
    """The absolute value."""
    return value.graph.value("abs", value.node)


def select(condition: Expression, a: Number, b: Number) -> Expression:
    """``a`` where the condition holds, else ``b``."""
    graph = condition.graph
    return graph.value("choose", condition.node, lifted(a, graph).node, lifted(b, graph).node)


def least(*values: Number) -> Any:
    """The least of any number of values, as a tree: its depth is what a processor waits for."""
    return _folded("min", values)


def most(*values: Number) -> Any:
    """The largest of any number of values, as a tree."""
    return _folded("max", values)


def clamp(value: Number, low: Number, high: Number) -> Any:
    """min(max(value, low), high): inside the limits, wherever they don't cross."""
    return least(most(value, low), high)


def _folded(kind: str, values: tuple[Number, ...]) -> Any:
    if len(values) == 1:
        return values[0]
    half = len(values) // 2
    a, b = _folded(kind, values[:half]), _folded(kind, values[half:])
    known = next((each.graph for each in (a, b) if isinstance(each, Expression)), None)
    if known is None:
        return min(a, b) if kind == "min" else max(a, b)
    return known.value(kind, lifted(a, known).node, lifted(b, known).node)
