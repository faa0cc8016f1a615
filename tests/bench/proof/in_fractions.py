"""A program calculated in fractions, without any rounding."""

from fractions import Fraction
from typing import Any

from alloc.allocation import FloatArray
from alloc.program import Program


def exactly(program: Program, tau: FloatArray) -> list[Any]:
    """Value of every node without rounding, conditions as bool."""
    made: list[Any] = []
    for operation, *operands in program.nodes:
        x = [made[each] for each in operands] if operation not in ("const", "input") else []
        match operation:
            case "const":
                made.append(Fraction(operands[0]))
            case "input":
                made.append(Fraction(float(tau[operands[1]])))
            case "div":
                made.append(x[0] / x[1] if x[1] else Fraction(0))
            case "choose":
                made.append(x[1] if x[0] else x[2])
            case _:
                made.append(OPERATIONS[operation](*x))
    return made


OPERATIONS: dict[str, Any] = {
    "add": lambda a, b: a + b, "sub": lambda a, b: a - b, "mul": lambda a, b: a * b, "neg": lambda a: -a,
    "abs": abs, "min": min, "max": max, "not": lambda a: not a,
    "lt": lambda a, b: a < b, "le": lambda a, b: a <= b, "gt": lambda a, b: a > b, "ge": lambda a, b: a >= b,
    "eq": lambda a, b: a == b, "ne": lambda a, b: a != b,
    "and": lambda a, b: a and b, "or": lambda a, b: a or b,
}  # fmt: skip
