"""A program calculated for many calls at once, in the scalar of the C or in a wider one."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc.program import Program
from alloc.program.evaluate import OPERATIONS
from bench.proof.not_read import NotRead

Array = NDArray[Any]


class Calculated(NamedTuple):
    """What a program answers to N calls.

    Attributes
    ----------
    outputs : array name to (size, N) values; of a call that is refused, what it would have written
    status : (N,) what is returned
    """

    outputs: dict[str, Array]
    status: Array


def answers(
    program: Program, inputs: Mapping[str, Array], scalar: Any, constants: Mapping[int, float] | None = None
) -> Calculated:
    """Calculate a program for inputs (size, N), each operation rounded to ``scalar`` (a numpy type).

    ``constants`` replaces those at some nodes. Raises NotRead where something is unknown.
    """
    return answered(program, values(program, inputs, scalar, constants))


def answered(program: Program, made: list[Any]) -> Calculated:
    """The answers in a program's ``values``."""
    count = max(np.size(each) for each in made)
    outputs: dict[str, list[Any]] = {}
    for (name, _), node in sorted(program.outputs.items()):
        outputs.setdefault(name, []).append(np.broadcast_to(made[node], count))
    with np.errstate(all="ignore"):
        status = np.broadcast_to(made[program.status], count).astype(int)
    for condition, returned in reversed(program.exits):
        status = np.where(made[condition], returned, status)
    return Calculated({name: np.array(rows) for name, rows in outputs.items()}, status)


def values(
    program: Program, inputs: Mapping[str, Array], scalar: Any, constants: Mapping[int, float] | None = None
) -> list[Any]:
    """What every node of a program is, as in ``answers``."""
    made: list[Any] = []
    with np.errstate(all="ignore"):
        for at, (operation, *operands) in enumerate(program.nodes):
            if operation == "const":
                made.append(scalar(constants.get(at, operands[0]) if constants else operands[0]))
            elif operation == "input":
                made.append(inputs[operands[0]][operands[1]].astype(scalar))
            elif operation == "unknown":
                raise NotRead("a loop")
            else:
                made.append(OPERATIONS[operation](*(made[each] for each in operands)))
    return made


def alike(program: Program, some: list[Any], others: list[Any]) -> Array:
    """(N,) whether two calculations of N calls take the same branches."""
    asked = [operation[1] for operation in program.nodes if operation[0] == "choose"]
    same: Array = np.ones(max(np.size(each) for each in some), dtype=bool)
    for condition in asked:
        same &= np.equal(some[condition], others[condition])
    return same
