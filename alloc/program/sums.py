"""Products of constant matrices with values; equal products and sums are made once."""

from collections import Counter
from itertools import combinations
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.program.graph import Expression, Graph, Number
from alloc.vehicle.degeneracy import ROUNDED

Terms = list[tuple[bool, Expression]]
"""A sum: for each term whether it is subtracted."""
SAME = 64 * np.finfo(float).eps
"""Entries of a matrix this close, relative to the larger, differ by rounding only."""


def snapped(matrix: FloatArray) -> FloatArray:
    """The matrix with sizes that differ by rounding made equal, and sizes that are rounding made zero."""
    sizes = np.abs(matrix)
    result = np.zeros_like(matrix)
    order = sorted(np.ndindex(matrix.shape), key=lambda at: float(sizes[at]))
    last = 0.0
    for at in order:
        if sizes[at] <= ROUNDED * sizes.max():  # far below the tolerance of any method
            continue
        if sizes[at] - last > SAME * sizes[at]:
            last = 1.0 if abs(sizes[at] - 1.0) <= SAME else float(sizes[at])
        result[at] = np.copysign(last, matrix[at])
    return result


class Products(NamedTuple):
    """A matrix times values: what is shared, each row's terms, and each column's largest product."""

    shared: list[Expression]
    rows: list[Terms]
    largest: list[Expression]


def product(matrix: FloatArray, into: list[Expression], name: str = "p") -> Products:
    """Matrix (m, k) times k values; equal sizes in a column are multiplied once.

    So a symmetric vehicle needs few multiplications.
    """
    M = snapped(matrix)
    shared: dict[tuple[float, int], Expression] = {}
    largest = []
    for j in range(M.shape[1]):
        sizes = Counter(float(size) for size in np.abs(M[:, j]) if size)
        for size in sorted(sizes, reverse=True):
            if sizes[size] > 1 or size == max(sizes):
                shared[size, j] = (size * into[j]).named(f"{name}{len(shared)}")
        largest.append(shared[max(sizes), j] if sizes else into[j])
    rows: list[Terms] = [
        [
            (value < 0, shared.get((abs(value), j)) or abs(value) * into[j])
            for j, value in enumerate(row)
            if value
        ]
        for row in M.tolist()
    ]
    return Products(list(shared.values()), rows, largest)


def gathered(matrix: FloatArray, into: list[Expression], name: str) -> list[Terms]:
    """Each row's terms of a matrix times values, where rows are few.

    Of equal sizes in a row the sum is multiplied, once; sums that rows share are taken once.
    """
    M = snapped(matrix)
    sums = {
        (r, size): [(bool(row[j] < 0), into[j]) for j in np.flatnonzero(np.abs(row) == size).tolist()]
        for r, row in enumerate(M)
        for size in np.unique(np.abs(row[row != 0])).tolist()
    }
    _, short = shared_sums(list(sums.values()), name)
    rows: list[Terms] = [[] for _ in M]
    for (r, size), terms in zip(sums, short, strict=True):
        # The sign of a sum's first term stands before the product.
        minus = terms[0][0]
        found = signed([(sign != minus, value) for sign, value in terms])
        rows[r].append((minus, size * found.named(f"{name}{r}_{len(rows[r])}")))
    return rows


def shared_sums(rows: list[Terms], name: str = "w") -> tuple[list[Expression], list[Terms]]:
    """Take each sum of two terms that several rows share once: these sums, and the shortened rows.

    The most frequent pair goes first (Paar's greedy rule); on Walsh's +-1 that makes the fast transform.
    """
    # Rows that are the same are one; a row may hold a value twice, and then has two keys for it.
    different = list({_key(row): row for row in reversed(rows)}.values())[::-1]
    values: list[Expression] = []
    keys: dict[tuple[Expression, int], int] = {}
    rest: list[dict[int, bool]] = []
    for row in different:
        often: Counter[Expression] = Counter()
        signs: dict[int, bool] = {}
        for minus, value in row:
            key = keys.setdefault((value, often[value]), len(keys))
            values += [value] if key == len(values) else []
            often[value] += 1
            signs[key] = minus
        rest.append(signs)
    made: list[Expression] = []
    while True:
        pairs = Counter((a, b, row[a] != row[b]) for row in rest for a, b in combinations(sorted(row), 2))
        (a, b, opposite), count = max(pairs.items(), key=lambda item: item[1], default=((0, 0, False), 0))
        if count < 2:
            short = [[(minus, values[key]) for key, minus in row.items()] for row in rest]
            of = dict(zip(map(_key, different), short, strict=True))
            return made, [of[_key(row)] for row in rows]
        total = values[a] - values[b] if opposite else values[a] + values[b]
        made.append(total.named(f"{name}{len(made)}"))
        values.append(total)
        for signs in rest:
            if a in signs and b in signs and (signs[a] != signs[b]) == opposite:
                signs[len(values) - 1] = signs.pop(a)
                del signs[b]


def _key(row: Terms) -> tuple[tuple[int, bool], ...]:
    """The same for two rows of the same terms."""
    return tuple(sorted((value.node, minus) for minus, value in row))


class Summed(NamedTuple):
    """A matrix times values: what is shared, in order, each row's terms, and how many terms all sums have."""

    shared: list[Expression]
    rows: list[Terms]
    terms: int


def summed(matrix: FloatArray, into: list[Expression], name: str) -> Summed:
    """Each row's terms of a matrix times values; products and sums that rows share are taken once."""
    products = product(matrix, into, f"p{name}")
    sums, rows = shared_sums(products.rows, f"s{name}")
    return Summed([*products.shared, *sums], rows, len(sums) + sum(map(len, rows)))


def signed(terms: Terms, graph: Graph | None = None) -> Expression:
    """a - b + …, a term that is added first; a sign before the whole sum costs an instruction more.

    ``graph`` makes the zero of a sum that may have no terms.
    """
    if not terms:
        assert graph is not None
        return graph.constant(0.0)
    minus = all(sign for sign, _ in terms)
    first = next((i for i, (sign, _) in enumerate(terms) if not sign), 0)
    found = terms[first][1]
    for sign, value in terms[:first] + terms[first + 1 :]:
        found = found - value if sign and not minus else found + value
    return -found if minus else found


def term(factor: float, value: Expression) -> tuple[bool, Expression]:
    """``factor`` times a value as a term of a sum."""
    return factor < 0, abs(factor) * value


def dot(factors: list[float], values: list[Expression]) -> Terms:
    """The terms of factors . values, without those that are zero."""
    return [term(factor, value) for factor, value in zip(factors, values, strict=True) if factor]


def is_constant(number: Number) -> bool:
    """True if a number is a constant."""
    return not isinstance(number, Expression)
