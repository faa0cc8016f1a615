"""T*, null-space basis and minors of T for many layouts at once."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations
from math import comb

import numpy as np

from alloc import Vehicle
from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.vehicle import RANK_TOLERANCE


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


@dataclass(frozen=True, eq=False, kw_only=True)
class Layouts:
    """B layouts, each k degrees of freedom and n thrusters; the last axis counts layouts.

    Attributes
    ----------
    T : (k, n, B) configuration matrices; force rows [-], moment rows [m]
    weights : (n, B) diagonal of H [1/N^2]
    f_min, f_max : (n, B) limits, with f_min <= 0 <= f_max and f_min < f_max [N]
    """

    T: FloatArray
    weights: FloatArray
    f_min: FloatArray
    f_max: FloatArray

    def __len__(self) -> int:
        return int(self.T.shape[2])

    def take(self, chosen: BoolArray | slice) -> "Layouts":
        """Some of the layouts."""
        return Layouts(
            T=self.T[..., chosen],
            weights=self.weights[:, chosen],
            f_min=self.f_min[:, chosen],
            f_max=self.f_max[:, chosen],
        )

    @cached_property
    def row_lengths(self) -> FloatArray:
        """(k, B) length of each row of T, and that of the longest for a row of zeros."""
        lengths = np.sqrt((self.T**2).sum(axis=1))
        longest = lengths.max(axis=0)
        counted: FloatArray = np.where(lengths > RANK_TOLERANCE * longest, lengths, longest)
        return counted

    @cached_property
    def wrench_scale(self) -> FloatArray:
        """(k, B) size of a wrench on each axis [N, N m], as ``alloc.Vehicle.wrench_scale``."""
        scale: FloatArray = self.row_lengths * np.maximum(np.abs(self.f_min), np.abs(self.f_max)).max(axis=0)
        return scale

    def singular_values(self, off: BoolArray | None = None) -> FloatArray:
        """(min(k, n), B) singular values of T in rows of unit length; ``off`` (n, B): those that are off."""
        T: FloatArray = self.T / self.row_lengths[:, None]
        if off is not None:
            T[:, off] = 0.0
        sigma: FloatArray = np.linalg.svd(T.transpose(2, 0, 1), compute_uv=False).T.astype(float, copy=False)
        return sigma


@dataclass(frozen=True, eq=False, kw_only=True)
class Spaces:
    """Spaces of layouts of full rank: all thrusts that push tau are f = G tau + N z.

    Attributes
    ----------
    sigma : (k, B) singular values of T in rows of unit length
    G : (n, k, B) T* of eq. 9
    N : (n, d, B) basis of the null space with N'HN = I
    content : (B,) sqrt(det TT'), the factor between the minors of T and those of an orthonormal basis
    minors : (C(n, d), B) of the orthonormal basis
    """

    sigma: FloatArray
    G: FloatArray
    N: FloatArray
    content: FloatArray
    minors: FloatArray

    @property
    def n(self) -> int:
        """Number of thrusters."""
        return len(self.N)

    @property
    def d(self) -> int:
        """Dimension of the null space."""
        return int(self.N.shape[1])

    @cached_property
    def dependencies(self) -> FloatArray:
        """(C(n, d + 1), d + 1, B) the part of c'T that is not zero, for the normal c of each facet."""
        return dependencies(self.minors, self.n, self.d)


def spaces(layouts: Layouts) -> tuple[BoolArray, Spaces]:
    """Mask of layouts of full rank (B,), and the spaces of those.

    T = U S V' gives the pseudoinverse and an orthonormal basis of the null space; where the weights of
    thrusters differ, both are turned into the ones of least f'Hf, as
    ``alloc.closed_forms.inverse.generalized_inverse`` does.
    """
    k, n, count = layouts.T.shape
    if n < k:
        return np.zeros(count, dtype=bool), _empty(k, n)
    lengths = layouts.row_lengths
    U, sigma, Vt = np.linalg.svd((layouts.T / lengths[:, None]).transpose(2, 0, 1))
    full = sigma[:, -1] > RANK_TOLERANCE
    U, sigma, Vt, lengths = U[full], sigma[full], Vt[full], lengths[:, full]
    plain = (Vt[:, :k].transpose(0, 2, 1) / sigma[:, None, :]) @ U.transpose(0, 2, 1)
    G = np.ascontiguousarray(plain.transpose(1, 2, 0)) / lengths
    N = np.ascontiguousarray(Vt[:, k:].transpose(2, 1, 0))
    found = minors(N)
    weights = layouts.weights[:, full]
    if n > k and (weights != weights[0]).any():
        G, N = _weighted(G, N, weights)
    elif n > k:
        N = N / np.sqrt(weights[:1])[:, None]
    content = sigma.prod(axis=1) * lengths.prod(axis=0)
    return full, Spaces(sigma=sigma.T, G=G, N=N, content=content, minors=found)


def _weighted(G: FloatArray, N: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """T* and a basis with N'HN = I from the pseudoinverse and an orthonormal basis, H = diag(weights)."""
    heavy = (N * weights[:, None]).transpose(2, 1, 0)  # (B, d, n): N'H
    plain = N.transpose(2, 0, 1)
    L = np.linalg.cholesky(heavy @ plain)
    turned = np.linalg.solve(L, plain.transpose(0, 2, 1)).transpose(0, 2, 1)  # N L'^-1
    along = (turned * weights.T[..., None]).transpose(0, 2, 1) @ G.transpose(2, 0, 1)
    best = G.transpose(2, 0, 1) - turned @ along
    return np.ascontiguousarray(best.transpose(1, 2, 0)), np.ascontiguousarray(turned.transpose(1, 2, 0))


def _empty(k: int, n: int) -> Spaces:
    zero = np.zeros
    return Spaces(
        sigma=zero((k, 0)), G=zero((n, k, 0)), N=zero((n, 0, 0)), content=zero(0), minors=zero((1, 0))
    )


def single_layout(vehicle: Vehicle) -> Layouts:
    """A vehicle whose H is diagonal as one layout."""
    return Layouts(
        T=vehicle.TP[..., None],
        weights=np.diag(vehicle.H)[:, None],
        f_min=vehicle.f_min[:, None],
        f_max=vehicle.f_max[:, None],
    )
