"""Templates of C loops over data: words stand for a vehicle's numbers and sizes."""

import re
from collections.abc import Mapping

from alloc.allocation import FloatArray
from alloc.program import Scalar
from alloc.program.literal import number


def unroll(text: str, sizes: Mapping[str, int]) -> str:
    """Repeat each line behind ``//each K`` for every index, which replaces ``_``.

    The unrolled line takes half the instructions of a loop.
    """

    def each(line: re.Match[str]) -> str:
        return "".join(line[1] + re.sub(r"(?<=[ze\[( ])_", f"{i}", line[3]) for i in range(sizes[line[2]]))

    return re.sub(rf"^( *)//each ({'|'.join(sizes)}) (.*\n)", each, text, flags=re.MULTILINE)


def fill_words(text: str, words: Mapping[str, str]) -> str:
    """Replace whole words of a text."""
    return re.sub(rf"\b({'|'.join(words)})\b", lambda word: words[word[0]], text)


def initialiser(values: FloatArray, scalar: Scalar) -> str:
    """C initialiser of an array of any dimension."""
    if values.ndim > 1:
        return "{" + ",\n".join(initialiser(each, scalar) for each in values) + "}"
    return "{" + ", ".join(number(value, scalar) for value in values.tolist()) + "}"
