"""Pieces of C99 for one set of constants: a table without repeats, and matrix products without zeros."""

import re
from collections import Counter
from itertools import combinations
from math import copysign
from typing import Literal, NamedTuple

import numpy as np

from alloc.allocation import WRENCH_TOLERANCE, FloatArray
from alloc.nullspace import allocator as nullspace

Scalar = Literal["double", "float"]
Terms = list[tuple[bool, str]]
"""A sum: for each term whether it is subtracted, and its C expression."""
Value = str | float
"""A C expression, or a number that is known beforehand."""
TOLERANCE: dict[Scalar, float] = {"double": nullspace.TOLERANCE, "float": 4e-6}
"""Excess over a limit that still counts as met, relative to the largest limit [-]. Float rounds at 6e-8; some
70 times that is left for the sums."""
MET: dict[Scalar, float] = {"double": WRENCH_TOLERANCE, "float": 1e-5}
"""What a SOLVED wrench may miss, relative to ``wrench_scale`` [-]; in single precision some hundred
roundings."""
SAME = 64 * np.finfo(float).eps
"""Entries of a matrix this close, relative to the larger, differ by rounding only."""


def number(value: float, scalar: Scalar) -> str:
    """The C99 literal of exactly that value, rounded to the scalar type first."""
    return float(np.float32(value)).hex() + "F" if scalar == "float" else float(value).hex()


class Table:
    """The constants of one kernel, each held once; the C refers to them as ``c[i]``."""

    def __init__(self, scalar: Scalar) -> None:
        """An empty table of that type."""
        self.scalar = scalar
        self._index: dict[str, int] = {}
        self._ratios = [1.0]

    def __call__(self, value: float) -> str:
        """The C expression for a constant; its sign stands in front, so that +-x share an entry."""
        entry = self._index.setdefault(number(abs(value), self.scalar), len(self._index))
        return f"{'-' if value < 0 else ''}c[{entry}]"

    def ratio(self, value: float) -> float:
        """The value, or one given here before that differs by rounding only; rounding itself is zero."""
        size = abs(value)
        if size <= 1e-14:
            return 0.0
        same = [known for known in self._ratios if abs(known - size) <= SAME * size]
        self._ratios += [] if same else [size]
        return copysign(same[0] if same else size, value)

    def define(self, name: str) -> str:
        """The table as a C definition."""
        values = ",\n    ".join(self._index)
        return f"static const {self.scalar} {name}[] = {{\n    {values}\n}};\n"


def snapped(matrix: FloatArray) -> FloatArray:
    """The matrix with sizes that differ by rounding made equal, and sizes that are rounding made zero."""
    sizes = np.abs(matrix)
    result = np.zeros_like(matrix)
    order = sorted(np.ndindex(matrix.shape), key=lambda at: float(sizes[at]))
    last = 0.0
    for at in order:
        if sizes[at] <= 1e-14 * sizes.max():  # far below the tolerance of any method
            continue
        if sizes[at] - last > SAME * sizes[at]:
            last = 1.0 if abs(sizes[at] - 1.0) <= SAME else float(sizes[at])
        result[at] = np.copysign(last, matrix[at])
    return result


def product(
    matrix: FloatArray, into: str, c: Table, prefix: str = "p"
) -> tuple[list[str], list[Terms], list[str]]:
    """C of matrix times [into0, into1, …]: lines, each row's terms, and each column's largest product.

    Equal sizes in a column are multiplied once, so a symmetric vehicle needs few multiplications.
    """
    M = snapped(matrix)
    lines: list[str] = []
    named: dict[tuple[float, int], str] = {}
    largest = []
    for j in range(M.shape[1]):
        sizes = Counter(float(size) for size in np.abs(M[:, j]) if size)
        for size in sorted(sizes, reverse=True):
            if sizes[size] > 1 or size == max(sizes):
                named[size, j] = f"{prefix}{len(named)}"
                lines.append(defined(named[size, j], f"{c(size)} * {into}{j}", c))
        largest.append(named[max(sizes), j] if sizes else f"{into}{j}")
    rows = [
        [
            (value < 0, named.get((abs(value), j)) or f"{c(abs(value))} * {into}{j}")
            for j, value in enumerate(row)
            if value
        ]
        for row in M.tolist()
    ]
    return lines, rows, largest


def gathered(matrix: FloatArray, into: str, c: Table, prefix: str) -> tuple[list[str], list[Terms]]:
    """C of matrix times [into0, into1, …] where rows are few: lines, and each row's terms.

    Of equal sizes in a row the sum is multiplied, once; sums that rows share are taken once.
    """
    M = snapped(matrix)
    sums = {
        (r, size): [(bool(row[j] < 0), f"{into}{j}") for j in np.flatnonzero(np.abs(row) == size)]
        for r, row in enumerate(M)
        for size in np.unique(np.abs(row[row != 0])).tolist()
    }
    lines, short = butterflies(list(sums.values()), c, prefix)
    rows: list[Terms] = [[] for _ in M]
    for (r, size), terms in zip(sums, short, strict=True):
        # The sign of a sum's first term stands before the product.
        minus = terms[0][0]
        text = signed_sum([(sign != minus, name) for sign, name in terms], c.scalar)
        if len(terms) > 1:
            lines.append(defined(f"{prefix}{r}_{len(rows[r])}", text, c))
            text = f"{prefix}{r}_{len(rows[r])}"
        rows[r].append(term(-size if minus else size, text, c))
    return lines, rows


def butterflies(rows: list[Terms], c: Table, prefix: str = "w") -> tuple[list[str], list[Terms]]:
    """Take each sum of two terms that several rows share once: lines of C, and the shortened rows.

    The most frequent pair goes first (Paar's greedy rule); on Walsh's +-1 that makes the fast transform.
    """
    rest = [{name: minus for minus, name in row} for row in rows]
    lines: list[str] = []
    while True:
        pairs = Counter((a, b, row[a] != row[b]) for row in rest for a, b in combinations(sorted(row), 2))
        (a, b, opposite), count = max(pairs.items(), key=lambda item: item[1], default=(("", "", False), 0))
        if count < 2:
            return lines, [[(minus, name) for name, minus in row.items()] for row in rest]
        name = f"{prefix}{len(lines)}"
        lines.append(defined(name, f"{a} {'-' if opposite else '+'} {b}", c))
        for row in rest:
            if a in row and b in row and (row[a] != row[b]) == opposite:
                row[name] = row.pop(a)
                del row[b]


class Summed(NamedTuple):
    """C of a matrix product: the lines that it needs, each row's terms, and how many terms all sums have."""

    lines: list[str]
    rows: list[Terms]
    terms: int


def summed(matrix: FloatArray, into: str, c: Table, name: str) -> Summed:
    """C of matrix times [into0, into1, …]; products and sums that rows share are taken once."""
    products, rows, _ = product(matrix, into, c, f"p{name}")
    sums, rows = butterflies(rows, c, f"s{name}")
    return Summed([*products, *sums], rows, len(sums) + sum(map(len, rows)))


def signed_sum(terms: Terms, scalar: Scalar) -> str:
    """``a - b + …``, a term that is added first; a sign before the whole sum costs an instruction more."""
    if not terms:
        return number(0.0, scalar)
    if all(minus for minus, _ in terms):
        return f"-({' + '.join(text for _, text in terms)})"
    first = next(i for i, (minus, _) in enumerate(terms) if not minus)
    rest = terms[:first] + terms[first + 1 :]
    return terms[first][1] + "".join(f" {'-' if minus else '+'} {text}" for minus, text in rest)


def dot(values: list[float], names: list[str], c: Table) -> str:
    """``values . names`` without zero terms and without multiplying by one."""
    terms = [term(value, name, c) for value, name in zip(values, names, strict=True) if value]
    return signed_sum(terms, c.scalar)


def term(value: float, name: str, c: Table) -> tuple[bool, str]:
    """``value * name`` as a term of a sum."""
    return value < 0, name if abs(value) == 1.0 else f"{c(abs(value))} * {name}"


def expression(value: Value, c: Table) -> str:
    """The C expression of a value, a constant where it is known beforehand."""
    return c(value) if isinstance(value, float) else value


def fold(function: str, terms: list[str]) -> str:
    """``most`` or ``least`` of any number of terms, as a tree: its depth is what a processor waits for."""
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return f"{function}({fold(function, terms[:half])}, {fold(function, terms[half:])})"


def reached(unreachable: FloatArray, c: Table) -> tuple[list[str], list[str]]:
    """Lines of C, and conditions that tau has no part along ``unreachable`` (see ``Structure``)."""
    lines, conditions = [], []
    for i, row in enumerate(unreachable):
        text = dot(row.tolist(), names("t", len(row)), c)
        lines.append(defined(f"lost{i}", text, c))
        conditions.append(f"(lost{i} >= {c(-TOLERANCE[c.scalar])}) & (lost{i} <= {c(TOLERANCE[c.scalar])})")
    return lines, conditions


def defined(name: str, value: str, c: Table) -> str:
    """The C statement that defines a constant of the scalar type."""
    return f"const {c.scalar} {name} = {value};"


def placed(definitions: list[str], statements: list[str]) -> list[str]:
    """The statements, each definition before the first of them that needs it; those that none needs left out.

    So few numbers are alive at a time, and fit a processor's registers.
    """
    waiting = {re.split(r"[ =]+", line)[2]: line for line in definitions}
    lines: list[str] = []

    def place(line: str) -> None:
        for word in re.findall(r"\b[a-z]\w*\b", line):
            if (needed := waiting.pop(word, None)) is not None:
                place(needed)
        lines.append(line)

    for statement in statements:
        place(statement)
    return lines


def names(prefix: str, count: int) -> list[str]:
    """Names prefix0, prefix1, … of ``count`` variables."""
    return [f"{prefix}{i}" for i in range(count)]
