"""Digits of a printed table: sets of columns that depend on each other but for the last one, single slips."""

from collections.abc import Mapping
from itertools import combinations, islice
from math import comb
from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import FLAT
from alloc.vehicle.geometry import decimals as printed_decimals

FEWEST, MOST = 4, 12
"""Decimals of a T that looks printed: with fewer, columns depend on each other by chance; with more the last
digit is near rounding."""
LEAST = 1e-4
"""Share of a row's largest entry from which on one is odd: what a slip changes by less, rounding does too."""
SURE = 4
"""Digits from which on two numbers that differ in one, or in two that are exchanged, look like a slip."""
SETS = 50_000
"""Most sets of columns that are looked at, within a second."""


def decimals(T: FloatArray) -> int | None:
    """How many decimals the entries of T have at most; None where these are not between FEWEST and MOST."""
    digits = printed_decimals(T)
    return digits if FEWEST <= digits <= MOST else None


def nearly_dependent(vehicle: Vehicle, digits: int) -> tuple[int, int]:
    """How many sets of rank T columns depend on each other but for their last digit, of how many.

    With rows of T in unit of ``row_lengths`` and columns of one length, half of the last decimal moves the
    least singular value of a set by at most the Frobenius norm of what it moves its entries by (Weyl). A set
    whose least singular value is no larger may be dependent in truth; one at rounding, FLAT, is so in print.
    """
    A = vehicle.T / vehicle.row_lengths[:, None]
    lengths = np.linalg.norm(A, axis=0)
    on, r = np.intersect1d(vehicle.working, np.flatnonzero(lengths)), vehicle.rank
    count = comb(len(on), r)
    if not r or count > SETS:
        return 0, 0
    A, lengths = A[:, on] / lengths[on], lengths[on]
    sets = np.array(list(islice(combinations(range(len(on)), r), count)))
    sigma = np.linalg.svd(A.T[sets], compute_uv=False)[:, r - 1]
    half = 0.5 * 10.0**-digits
    moved = np.linalg.norm(half / vehicle.row_lengths) / lengths
    near = (sigma > FLAT) & (sigma <= np.sqrt((moved[sets] ** 2).sum(axis=1)))
    return int(near.sum()), count


class OddEntry(NamedTuple):
    """An entry of a table that alone breaks a symmetry which all others keep.

    Attributes
    ----------
    row, column : where it stands
    twins : the columns that are its column's images but for this entry
    expected : what it would be by them
    image : how they are its images, in words
    """

    row: int
    column: int
    twins: tuple[int, ...]
    expected: float
    image: str


def odd_entry(A: FloatArray, images: Mapping[str, FloatArray]) -> OddEntry | None:
    """The only entry of A (m, n) that breaks one of the symmetries ``images``; None without one.

    Each symmetry has its signs (s, m): an image of a column is its product with one of them. Every column
    has an image among the others, or is its own, but for two, which are each other's but for one entry. In a
    vehicle that is meant to be uneven some thruster has no image at all, or two entries differ. Of the two
    entries the one is odd whose size stands more rarely in its row.
    """
    # Rows of a few digits are printed to them all; in others numbers differ that a program rounded apart.
    most = np.abs(A).max(axis=1, initial=0.0)
    digits = [decimals(row) for row in A]
    near = np.array([1.01 * 10.0**-d if d else 1e-9 * top for d, top in zip(digits, most, strict=True)])
    for image, signs in images.items():
        off = np.abs(signs[:, :, None, None] * A[:, :, None] - A[:, None, :]) > near[:, None, None]
        alike: BoolArray = np.logical_or.reduce(~off.any(axis=1))
        lone, pairs = set(range(A.shape[1])), 0
        for i in range(A.shape[1]):
            others = [j for j in lone if alike[i, j] and j != i] if i in lone else []
            if others:
                pairs += not alike[i, i]
                lone -= {i, others[0]}
            elif alike[i, i]:
                lone -= {i}
        if len(lone) != 2 or not pairs:
            continue
        a, b = sorted(lone)
        for sign, one in zip(signs, off[:, :, a, b], strict=True):
            row = int(one.argmax())
            if one.sum() == 1 and abs(sign[row] * A[row, a] - A[row, b]) > LEAST * most[row]:
                return _oddest(np.abs(A), near, row, (a, b), sign[row] * A[row], image)
    return None


def _oddest(
    sizes: FloatArray, near: FloatArray, row: int, pair: tuple[int, int], reflected: FloatArray, image: str
) -> OddEntry:
    """The one of a pair whose entry in a row is the odd one, with all that are as its twin is."""
    often = [int((np.abs(sizes[row] - sizes[row, i]) <= near[row]).sum()) for i in pair]
    twin, odd = pair if often[0] >= often[1] else pair[::-1]
    others = np.delete(np.arange(len(sizes)), row)
    twins = np.flatnonzero(
        (np.abs(sizes - sizes[:, [twin]]) <= near[:, None]).all(axis=0)
        & (np.abs(sizes - sizes[:, [odd]]) <= near[:, None])[others].all(axis=0)
    )
    return OddEntry(row, odd, tuple(twins.tolist()), float(reflected[twin]), image)


def slips(a: float, b: float) -> tuple[int, bool]:
    """How many decimal digits two numbers differ in, and whether they are two that are exchanged.

    Numbers with fewer than SURE digits differ in all of them: there one digit is no coincidence.
    """
    texts = [np.format_float_positional(abs(each), trim="k").split(".") for each in (a, b)]
    before, behind = (max(len(text[side]) for text in texts) for side in (0, 1))
    first, second = (text[0].zfill(before) + text[1].ljust(behind, "0") for text in texts)
    apart = [(x, y) for x, y in zip(first, second, strict=True) if x != y]
    if min(len(each.strip("0")) for each in (first, second)) < SURE:
        return before + behind, False
    return len(apart), len(apart) == 2 and apart[0] == apart[1][::-1]
