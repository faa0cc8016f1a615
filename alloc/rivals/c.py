"""Small pieces of C text: arrays, and a generator's double precision turned into single."""

import re

import numpy as np
from numpy.typing import ArrayLike

from alloc.program import Scalar
from alloc.program.literal import number

_LITERAL = re.compile(r"(?<![\w.])((?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)(?![\w.])")
_FUNCTION = re.compile(r"\b(sqrt|fabs|fmin|fmax)\(")


def array(name: str, values: ArrayLike, scalar: Scalar) -> str:
    """The definition of a constant static array with these values, row by row."""
    flat = np.asarray(values, dtype=np.float64).ravel().tolist()
    texts = ", ".join(number(value, scalar) for value in flat)
    return f"static const {scalar} {name}[{len(flat)}] = {{{texts}}};"


def indices(name: str, values: ArrayLike) -> str:
    """The definition of a constant static array of int."""
    flat = np.asarray(values, dtype=np.int64).ravel().tolist()
    return f"static const int {name}[{len(flat)}] = {{{', '.join(map(str, flat))}}};"


def single(text: str) -> str:
    """C in double precision as C in single: its types, constants, and functions of the mathematical library.

    For generators that write double only. Constants too, since a processor whose FPU is single calculates
    every product with a double in software. One too small or too large for single precision becomes the
    smallest or largest: it stands for the same of double.
    """
    text = re.sub(r"\bdouble\b", "float", text)
    return _FUNCTION.sub(r"\1f(", _LITERAL.sub(_within_single, text))


def _within_single(literal: re.Match[str]) -> str:
    limits = np.finfo(np.float32)
    value = float(literal[0])
    nearest = min(max(value, float(limits.smallest_normal)), float(limits.max)) if value else value
    return f"{literal[0] if nearest == value else repr(nearest)}F"
