"""Numbers as C99 literals."""

import numpy as np

from alloc.program.nodes import Scalar


def number(value: float, scalar: Scalar) -> str:
    """The C99 literal of exactly that value, rounded to the scalar type first."""
    return float(np.float32(value)).hex() + "F" if scalar == "float" else float(value).hex()
