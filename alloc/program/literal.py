"""Numbers as C literals."""

import numpy as np

from alloc.program.nodes import Scalar


def number(value: float, scalar: Scalar) -> str:
    """The decimal literal of exactly that value, rounded to the scalar type first.

    Of a double the shortest that is read back as it, of a float nine digits, which are it also where a
    compiler reads a double and rounds that. Hexadecimal ones are no C++ before C++17.
    """
    text = f"{np.float32(value):.9g}" if scalar == "float" else repr(float(value))
    return (text if set(text) & set(".en") else f"{text}.0") + ("F" if scalar == "float" else "")
