"""C of loops over data: a text with a vehicle's numbers and sizes in the place of words."""

import re
from collections.abc import Mapping

from alloc.allocation import FloatArray
from alloc.program import Scalar
from alloc.program.literal import number


def unrolled(text: str, sizes: Mapping[str, int]) -> str:
    """Write each line behind ``//each K`` so many times, with an index in the place of ``_``.

    Without a loop it takes half the instructions.
    """

    def each(line: re.Match[str]) -> str:
        return "".join(line[1] + re.sub(r"(?<=[ze\[( ])_", f"{i}", line[3]) for i in range(sizes[line[2]]))

    return re.sub(rf"^( *)//each ({'|'.join(sizes)}) (.*\n)", each, text, flags=re.MULTILINE)


def filled(text: str, words: Mapping[str, str]) -> str:
    """The text with other words for these."""
    return re.sub(rf"\b({'|'.join(words)})\b", lambda word: words[word[0]], text)


def initialiser(values: FloatArray, scalar: Scalar) -> str:
    """C initialiser of an array of any dimension."""
    if values.ndim > 1:
        return "{" + ",\n".join(initialiser(each, scalar) for each in values) + "}"
    return "{" + ", ".join(number(value, scalar) for value in values.tolist()) + "}"
