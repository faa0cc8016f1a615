"""The least alpha* at which a demand may still be SOLVED, from the program's own numbers."""

from collections.abc import Sequence
from math import inf
from typing import Any

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.program import Node, Operation, Program, Scalar, values
from bench.demands.corners import attainable
from bench.proof.not_read import NotRead
from bench.proof.rounding.arithmetic import WIDER
from bench.proof.rounding.errors import Errors
from bench.proof.rounding.seen import KINDS

DEMANDS = 20_000
"""Attainable demands, a third of them on the edge, that tell how large what is compared becomes there."""
FAR = 2.0
"""So many times an attainable demand, or its opposite, changes all that depends on what thrusters can do."""
NOTHING = 100.0
"""What changes by no more than so many times its rounding does not change: constants are rounded, too."""


def verdict_band(program: Program, errors: Errors, vehicle: Vehicle, scalar: Scalar) -> float | None:
    """1 - alpha* of the least attainable demand that may be SOLVED still [-]; None where none is refused.

    What is compared with a bound b is convex along the ray to a demand: r at its begin, at most m wherever
    the demand is attainable. It is answered where that is at most b + e, e the rounding error, so that
    alpha* >= 1 / (1 + (b + e - m) / (m - r)). All of these are the program's own: b and r are its numbers,
    and m is the largest of many attainable demands, which is no more than the true one and so widens the
    band. Where m is r but for rounding there is none: demands as small as the slack pass, however little of
    them can be had. What no multiple of a demand changes is no edge of the set: a thruster's own limits,
    which don't cross, or a direction that no thruster pushes. Raises NotRead where what is compared can't be
    followed.
    """
    taus, at_rest = attainable(vehicle, np.random.default_rng(2004), DEMANDS), _at_rest(program)
    largest, *far = (_largest(program, by * taus, scalar) for by in (1.0, FAR, -FAR))
    band = None
    for condition, _ in program.exits:
        for term, bound in _compared(program.nodes, condition):
            if term not in errors.values or bound not in errors.values:
                raise NotRead(errors.reasons.get(term, "no number"))
            error = errors.error(term) + WIDER["double"] * errors.values[term].size
            if all(each[term] - at_rest[term] <= NOTHING * error for each in far):
                continue
            width = largest[term] - at_rest[term]
            beyond = errors.values[bound].high - largest[term] + error
            band = max(band or 0.0, 1.0 - 1.0 / (1.0 + beyond / width) if width > NOTHING * error else inf)
    return band


def _largest(program: Program, taus: FloatArray, scalar: Scalar) -> list[Any]:
    """The largest that every node is of these demands (k, N), calculated in the wider scalar."""
    each = values(program, {"tau": taus}, KINDS[scalar][1])
    return [None if one is None else float(np.max(one)) for one in each]


def _at_rest(program: Program) -> list[Any]:
    """Values of every node where tau is zero."""
    named = {operation[1]: operation[2] for operation in program.nodes if operation[0] == "input"}
    inputs = {name: np.zeros((last + 1, 1)) for name, last in named.items()}
    return [
        None if each is None else float(np.ravel(each)[0]) for each in values(program, inputs, np.float64)
    ]


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
