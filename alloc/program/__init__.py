"""What a kernel computes, as a value: a graph of operations that printers, evaluators and proofs read."""

from alloc.program.builder import Builder
from alloc.program.evaluate import Evaluated, alike, answered, evaluate, values
from alloc.program.graph import Expression, Graph, Number, least, most, select, size, within
from alloc.program.limits import Limits
from alloc.program.nodes import (
    OWN,
    Branch,
    DataLoop,
    Exit,
    Fence,
    Node,
    Operation,
    Program,
    Scalar,
    Step,
    Where,
    Write,
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
    "Fence",
    "Graph",
    "Limits",
    "Node",
    "Number",
    "Operation",
    "Program",
    "Scalar",
    "Step",
    "Where",
    "Write",
    "alike",
    "answered",
    "evaluate",
    "least",
    "most",
    "operands",
    "placed",
    "reachable",
    "select",
    "size",
    "values",
    "within",
]  # fmt: skip
