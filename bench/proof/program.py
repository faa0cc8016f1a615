"""A kernel's C as a list of operations: what each output is, in terms of the arguments."""

from dataclasses import dataclass, field
from typing import Any

Node = int
"""Index of an operation in ``Program.nodes``."""
Operation = tuple[Any, ...]
"""What is done, then its operands: ("add", 3, 4); ("const", 1.5); ("input", "tau", 0); ("unknown", 7).

Of values: add, sub, mul, div, neg, abs, min, max, choose (condition, then, else). Of conditions: lt, le, gt,
ge, eq, ne, not, and, or. ``min`` is C's a < b ? a : b, so that the second operand stands where one is NaN.
"""


@dataclass
class Program:
    """One function, for one fault, as operations in the order of their needs.

    Attributes
    ----------
    nodes : the operations
    exits : conditions, each with what is returned where it holds, unless one before it held
    status : what is returned else
    outputs : (array, index) to what is written there
    """

    nodes: list[Operation] = field(default_factory=list)
    exits: list[tuple[Node, int]] = field(default_factory=list)
    status: Node = -1
    outputs: dict[tuple[str, int], Node] = field(default_factory=dict)

    def add(self, *operation: Any) -> Node:
        """The node of an operation."""
        self.nodes.append(operation)
        return len(self.nodes) - 1


class NotRead(Exception):
    """The C holds something that is not read; the message says what."""
