"""Floating-point numbers that a binary calculates from its arguments, and how they compare."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.proof.path.cases import Integer, case, evaluated

Array = NDArray[Any]


class Float(NamedTuple):
    """A number that is known by how it is calculated: an index in ``Numbers.made``."""

    node: int


class Numbers:
    """All numbers of a kernel with one fault, each operation once.

    Attributes
    ----------
    made : operations: ("input", name, j), ("const", 1.5), or what is done and its operands; ("choose",
        condition, a, b) gives a where the condition, an integer of ``cases``, is not zero
    compared : pairs of nodes
    calls : input name to (size, N) values
    """

    def __init__(self, scalar: Any, calls: dict[str, Array]) -> None:
        """Nothing calculated yet, of N calls in a numpy type."""
        self.scalar = scalar
        self.made: list[tuple[Any, ...]] = []
        self.compared: list[tuple[int, int]] = []
        self._known: dict[tuple[Any, ...], int] = {}
        self._asked: dict[tuple[int, int], int] = {}
        self.ask(calls)

    def ask(self, calls: dict[str, Array]) -> None:
        """Take other calls for those there are."""
        with np.errstate(over="ignore"):
            self.calls = {name: each.astype(self.scalar) for name, each in calls.items()}
        self.size = next(iter(calls.values())).shape[1]
        self._values: list[Array] = []
        self._outcomes: list[NDArray[np.int8]] = []

    def trial(self, calls: dict[str, Array]) -> "Numbers":
        """The same numbers, of other calls."""
        other = Numbers(self.scalar, calls)
        other.made, other.compared = self.made, self.compared
        return other

    def number(self, *operation: Any) -> Float:
        """The number that an operation gives."""
        if operation[0] == "const":  # zeros of both signs are two numbers, and NaN is one
            operation = ("const", float(operation[1]).hex())
        if operation not in self._known:
            self._known[operation] = len(self.made)
            self.made.append(("const", float.fromhex(operation[1])) if operation[0] == "const" else operation)
        return Float(self._known[operation])

    def compare(self, a: Float, b: Float, codes: tuple[int, int, int, int]) -> Integer:
        """One of the codes, by outcome."""
        if a.node > b.node:
            a, b, codes = b, a, (codes[2], codes[1], codes[0], codes[3])
        pair = (a.node, b.node)
        if pair not in self._asked:
            self._asked[pair] = len(self.compared)
            self.compared.append(pair)
        return case(self._asked[pair], codes)

    def values(self, node: int) -> Array:
        """(N,) what a number is."""
        with np.errstate(all="ignore"):
            while len(self._values) <= node:
                self._values.append(self._value(*self.made[len(self._values)]))
        return self._values[node]

    def integer(self, integer: Integer) -> NDArray[np.int64]:
        """(N,) what an integer is."""
        return evaluated(integer, self._outcome, self.size)

    def _outcome(self, compare: int) -> NDArray[np.int8]:
        while len(self._outcomes) <= compare:
            a, b = (self.values(node) for node in self.compared[len(self._outcomes)])
            self._outcomes.append(np.select([a < b, a == b, a > b], [0, 1, 2], 3).astype(np.int8))
        return self._outcomes[compare]

    def _value(self, operation: str, *operands: Any) -> Array:
        match operation:
            case "const":
                return np.full(self.size, operands[0], dtype=self.scalar)
            case "input":
                given: Array = self.calls[operands[0]][operands[1]]
                return given
            case "choose":
                condition, a, b = operands
                chosen: Array = np.where(self.integer(condition) != 0, self._values[a], self._values[b])
                return chosen
        calculated: Array = CALCULATED[operation](*(self._values[each] for each in operands))
        return calculated


CALCULATED: dict[str, Any] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "sqrt": np.sqrt,
    "neg": np.negative, "abs": np.abs, "min": np.fmin, "max": np.fmax,
}  # fmt: skip
"""``min`` and ``max`` are IEEE 754's minNum and maxNum: of NaN and a number, the number."""
