"""Integers that hang on comparisons of floating-point numbers: decision trees with integers as leaves.

A processor compares two numbers with one of four outcomes. What it then does with flags, and with integers
made of them, is known for each outcome, so that a condition of a branch is a tree of the comparisons that it
hangs on. Trees are ordered by the comparison's number and never ask the same one twice.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LESS, EQUAL, GREATER, UNORDERED = range(4)
"""Outcomes of a comparison; unordered where one of the two is NaN."""


class ByOutcome(NamedTuple):
    """What an integer is for each outcome of one comparison.

    Attributes
    ----------
    compare : the comparison's number
    leaves : the integer, or a further case, for each of the four outcomes
    """

    compare: int
    leaves: "tuple[Integer, Integer, Integer, Integer]"


Integer = int | ByOutcome


def combined(function: Callable[..., int], *given: Integer) -> Integer:
    """``function`` of integers, for each combination of outcomes that they hang on."""
    asked = [each.compare for each in given if isinstance(each, ByOutcome)]
    if not asked:
        return function(*given)
    first = min(asked)
    leaves = tuple(combined(function, *(_at(each, first, outcome) for each in given)) for outcome in range(4))
    return case(first, leaves)


def case(compare: int, leaves: tuple[Integer, ...]) -> Integer:
    """A case, or the integer where it is the same for each outcome."""
    a, b, c, d = leaves
    return a if a == b == c == d else ByOutcome(compare, (a, b, c, d))


def _at(integer: Integer, compare: int, outcome: int) -> Integer:
    return (
        integer.leaves[outcome] if isinstance(integer, ByOutcome) and integer.compare == compare else integer
    )


def compares(integer: Integer) -> set[int]:
    """The comparisons that an integer hangs on."""
    if not isinstance(integer, ByOutcome):
        return set()
    return {integer.compare}.union(*(compares(leaf) for leaf in set(integer.leaves)))


def evaluated(integer: Integer, outcome: Callable[[int], NDArray[np.int8]], size: int) -> NDArray[np.int64]:
    """(size,) the integer for each of so many calls; ``outcome`` gives (size,) outcomes of a comparison."""
    if not isinstance(integer, ByOutcome):
        return np.full(size, integer, dtype=np.int64)
    leaves = [evaluated(leaf, outcome, size) for leaf in integer.leaves]
    chosen: NDArray[np.int64] = np.choose(outcome(integer.compare), leaves)
    return chosen
