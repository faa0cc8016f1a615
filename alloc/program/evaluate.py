"""Evaluate a program with numpy for many calls, with the bits of its C or in a wider scalar."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc.allocation import BoolArray, FloatArray, StatusArray
from alloc.errors import NotApplicable
from alloc.program.nodes import Node, Operation, Program, operands, reachable

Array = NDArray[Any]


class Evaluated(NamedTuple):
    """Answers of a program to N calls.

    Attributes
    ----------
    F : (N, n) thrusts [N]; of a call that is refused, what it would have written
    status : (N,) what is returned
    share : (N, levels) what of each level is delivered [-]
    """

    F: FloatArray
    status: StatusArray
    share: FloatArray


def evaluate(
    program: Program, taus: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
) -> Evaluated:
    """Answer demands (N, k) within limits (N, n), where the program takes these.

    Every operation is rounded to the program's scalar, and C's minimum, a < b ? a : b, is taken. Raises
    NotApplicable for a program with a loop over data.
    """
    given = {"tau": taus, "f_min": f_min, "f_max": f_max}
    inputs = {name: np.ascontiguousarray(array.T) for name, array in given.items() if array is not None}
    kind = np.float32 if program.scalar == "float" else np.float64
    F, status, share = answered(program, values(program, inputs, kind), len(taus))
    return Evaluated(F.astype(np.float64), status, share.astype(np.float64))


def answered(program: Program, made: list[Any], count: int) -> Evaluated:
    """The answers to so many calls in a program's ``values``."""
    with np.errstate(all="ignore"):
        status = np.broadcast_to(made[program.status], count).astype(np.int8)
    for condition, returned in reversed(program.exits):
        status = np.where(made[condition], np.int8(returned), status)

    def written(array: str) -> Array:
        rows = [made[program.outputs[array, i]] for i in range(program.size(array))]
        both = [np.broadcast_to(row, count) for row in rows]
        return np.array(both).reshape(len(rows), count).T

    return Evaluated(written("f"), status, written("share"))


def values(
    program: Program, inputs: Mapping[str, Array], scalar: Any, constants: Mapping[Node, float] | None = None
) -> list[Any]:
    """Values of every node that an answer needs, for inputs (size, N); None for all others.

    Each operation is rounded to ``scalar``, a numpy type. ``constants`` replaces those at some nodes. Raises
    NotApplicable where something is unknown.
    """
    columns = {name: array.astype(scalar, copy=False) for name, array in inputs.items()}
    made: list[Any] = [None] * len(program.nodes)
    with np.errstate(all="ignore"):
        for node in reachable(program.nodes, program.roots):
            made[node] = _calculated(program.nodes[node], made, columns, scalar)
            if constants and node in constants:
                made[node] = scalar(constants[node])
    return made


def alike(program: Program, some: list[Any], others: list[Any]) -> BoolArray:
    """(N,) whether two calculations of the same calls take the same branches."""
    same: Any = np.True_
    for (kind, *needed), value in zip(program.nodes, some, strict=True):
        if kind == "choose" and value is not None:
            same = same & np.equal(some[needed[0]], others[needed[0]])
    return np.broadcast_to(same, max(map(np.size, some)))


def _calculated(operation: Operation, made: list[Any], columns: dict[str, Array], kind: Any) -> Any:
    match operation:
        case ("const", value):
            return kind(value)
        case ("input", array, index):
            return columns[array][index]
        case ("again", inner):
            return made[inner]
        case ("finite", array, first, count):
            return np.isfinite(columns[array][first : first + count]).all(axis=0)
        case ("loop" | "unknown", *_):
            raise NotApplicable("a loop over data: its C alone calculates that")
    return OPERATIONS[operation[0]](*(made[each] for each in operands(operation)))


OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide,
    "neg": np.negative, "abs": np.abs,
    "lt": np.less, "le": np.less_equal, "gt": np.greater, "ge": np.greater_equal,
    "eq": np.equal, "ne": np.not_equal,
    "not": np.logical_not, "and": np.logical_and, "or": np.logical_or,
    "min": lambda a, b: np.where(a < b, a, b),
    "max": lambda a, b: np.where(a > b, a, b),
    "choose": np.where,
}  # fmt: skip
"""numpy's operations; the second operand stands where a minimum or maximum meets NaN, as in C."""
