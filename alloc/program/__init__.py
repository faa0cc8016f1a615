"""What a kernel computes, as a value: a graph of operations that printers, evaluators and proofs read."""

from alloc.program.at_fault import at_fault
from alloc.program.builder import Builder
from alloc.program.evaluate import Evaluated, alike, answered, evaluate, values
from alloc.program.graph import Expression, Graph, Number, least, most, select, size, within
from alloc.program.limits import Limits, States, states
from alloc.program.nodes import (
    OWN,
    Branch,
    DataLoop,
    Exit,
    Faults,
    Fence,
    Node,
    Operation,
    Program,
    Scalar,
    Step,
    Where,
    Write,
    every,
    named,
    operands,
    reachable,
)
from alloc.program.order import placed

__all__ = [
    "OWN",
    "Branch",
    "Builder",
    "DataLoop",
    "Evaluated",
    "Exit",
    "Expression",
    "Faults",
    "Fence",
    "Graph",
    "Limits",
    "Node",
    "Number",
    "Operation",
    "Program",
    "Scalar",
    "States",
    "Step",
    "Where",
    "Write",
    "alike",
    "answered",
    "at_fault",
    "evaluate",
    "every",
    "least",
    "most",
    "named",
    "operands",
    "placed",
    "reachable",
    "select",
    "size",
    "states",
    "values",
    "within",
]  # fmt: skip
