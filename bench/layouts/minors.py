"""Determinants of all d rows out of n, for many matrices at once.

Of an orthonormal basis N of the null space of T they are, up to one factor, the determinants of all n - d
columns of T: |det T_I| = sqrt(det TT') |det N_J|, J the rows that are not in I (Jacobi's complementary
minors). With d of 1 to 3 they are far fewer operations than eliminating in T would take.
"""

from functools import lru_cache
from itertools import combinations
from math import comb

import numpy as np

from alloc.allocation import FloatArray, IndexArray


@lru_cache(maxsize=64)
def subsets(n: int, size: int) -> IndexArray:
    """(C(n, size), size) all subsets of 0 ... n - 1 in lexicographic order."""
    return np.array(list(combinations(range(n), size)), dtype=np.intp).reshape(comb(n, size), size)


@lru_cache(maxsize=64)
def without(n: int, size: int) -> IndexArray:
    """(C(n, size), size) where each subset less its p-th member stands among the smaller subsets."""
    place = {tuple(smaller): i for i, smaller in enumerate(subsets(n, size - 1).tolist())}
    rows = [[place[(*s[:p], *s[p + 1 :])] for p in range(size)] for s in subsets(n, size).tolist()]
    return np.array(rows, dtype=np.intp).reshape(comb(n, size), size)


def minors(A: FloatArray) -> FloatArray:
    """(C(n, d), ...) determinant of each d rows of A (n, d, ...), in the order of ``subsets``."""
    n, d = A.shape[:2]
    found = np.ones((1, *A.shape[2:]))
    for size in range(1, d + 1):
        members, smaller = subsets(n, size), without(n, size)
        # Laplace's expansion along the last of the first `size` columns.
        found = sum(
            (-1.0) ** (p + size - 1) * A[members[:, p], size - 1] * found[smaller[:, p]] for p in range(size)
        )
    return found


def dependencies(found: FloatArray, n: int, d: int) -> FloatArray:
    """(C(n, d + 1), d + 1, ...) y with sum_p y_p A[row p] = 0 of each d + 1 rows of A (n, d, ...).

    ``found`` are A's minors. The coefficient of a row is, but for its sign, the minor of the other rows.
    """
    signs = (-1.0) ** np.arange(d + 1).reshape(1, -1, *(1,) * (found.ndim - 1))
    coefficients: FloatArray = signs * found[without(n, d + 1)]
    return coefficients


def inverse(A: FloatArray, smallest: float) -> FloatArray:
    """Inverses of small matrices A (d, d, ...) by cofactors; 0 where |A| is below ``smallest``."""
    d = len(A)
    cofactors = np.empty_like(A)
    for column in range(d):
        rest = np.delete(A, column, axis=1)
        # The last of the (d - 1)-subsets of rows leaves out row 0.
        for row, minor in enumerate(minors(rest)[::-1]):
            cofactors[row, column] = (-1.0) ** (row + column) * minor
    determinant = (A[:, 0] * cofactors[:, 0]).sum(axis=0)
    singular = np.abs(determinant) < smallest
    inverses: FloatArray = cofactors.swapaxes(0, 1) / np.where(singular, np.inf, determinant)
    return inverses
