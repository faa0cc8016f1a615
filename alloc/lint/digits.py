"""A T printed to a few digits: which sets of its columns depend on each other but for the last one."""

from itertools import combinations, islice
from math import comb

import numpy as np

from alloc.allocation import FloatArray
from alloc.vehicle import Vehicle, columns
from alloc.vehicle.degeneracy import FLAT

FEWEST, MOST = 4, 12
"""Decimals of a T that looks printed: with fewer, columns depend on each other by chance; with more the last
digit is near rounding."""
SETS = 50_000
"""Most sets of columns that are looked at, within a second."""


def decimals(T: FloatArray) -> int | None:
    """How many decimals the entries of T have at most; None where these are not between FEWEST and MOST."""
    digits = columns.decimals(T)
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
