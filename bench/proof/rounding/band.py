"""How far below 1 alpha* may be of a demand that is SOLVED still: what tolerance and rounding allow."""

from collections.abc import Sequence
from math import inf

import numpy as np

from alloc.program import Node, Operation, Program
from bench.proof.not_read import NotRead
from bench.proof.numeric import values
from bench.proof.rounding.errors import Errors


def verdict_band(program: Program, errors: Errors, slack: float) -> float | None:
    """1 - alpha* of the least attainable demand that may be SOLVED still [-]; None where none is refused.

    An excess g over the limits is convex along the ray to a demand, -w at its begin and 0 at alpha*. A
    demand is answered where g is at most slack + e, e its rounding error, so that
    alpha* >= 1 / (1 + (slack + e) / w). Raises NotRead where an excess can't be followed.
    """
    at_rest = _at_rest(program)
    band = None
    for condition, _ in program.exits:
        for term, bound in _compared(program.nodes, condition):
            if term not in errors.values or bound not in errors.values:
                raise NotRead(errors.reasons.get(term, "no number"))
            value = errors.values[term]
            if value.form and value.size <= errors.values[bound].high:
                continue  # of an attainable demand this is zero: a direction that no thruster pushes
            width = errors.values[bound].low - at_rest[term] - slack
            beyond = slack + errors.error(term)
            band = max(band or 0.0, 1.0 - 1.0 / (1.0 + beyond / width) if width > 0 else inf)
    return band


def _at_rest(program: Program) -> list[float]:
    """What every node is where tau is zero."""
    named = {operation[1]: operation[2] for operation in program.nodes if operation[0] == "input"}
    inputs = {name: np.zeros((last + 1, 1)) for name, last in named.items()}
    return [float(np.asarray(each).ravel()[0]) for each in values(program, inputs, np.float64)]


def _compared(nodes: Sequence[Operation], condition: Node) -> list[tuple[Node, Node]]:
    """Pairs (what must not exceed, what it may be) that a refusal compares; each maximum taken apart."""
    match nodes[condition]:
        case ("not", inner) if nodes[inner][0] == "le":
            _, left, bound = nodes[inner]
            return [(term, bound) for term in _maxima(nodes, left)]
        case ("and", a, b):
            return _compared(nodes, a) + _compared(nodes, b)
    return []


def _maxima(nodes: Sequence[Operation], node: Node) -> list[Node]:
    match nodes[node]:
        case ("max", a, b):
            return _maxima(nodes, a) + _maxima(nodes, b)
        case ("add", a, b) if nodes[b][0] == "sub" and nodes[b][1] == nodes[b][2]:
            return _maxima(nodes, a)
        case ("sub", a, b) if a == b:
            return []
    return [node]
