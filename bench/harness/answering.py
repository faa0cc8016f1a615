"""What an allocator answers to many demands at once, and whether its single calls answer the same."""

from functools import partial

import numpy as np

from alloc import Allocator
from alloc.allocation import FloatArray, StatusArray, real
from alloc.live.plain import ANY_DISTANCE
from alloc.vehicle.call_limits import one_by_one
from bench.demands.store import Case

ASKED = 50
"""Demands of a case that are asked in single calls too."""
MOST_APART = 2
"""How many of them may be answered otherwise: what a solver that starts from its last answer finds hangs on
the order of demands, but seldom."""
ROUGHLY = 1e-3
"""How far answers may lie apart where no distance is promised, relative to the largest limit [-]."""


def answers_of(allocator: Allocator, case: Case, *, brought: bool) -> tuple[FloatArray, StatusArray]:
    """Thrusts (N, n) [N] and statuses (N,) by ``many``, or by calls where an allocator has no such function.

    ``brought`` says that the method is a user's: then ``many`` is held against single calls, since what is
    reported of it is what a vehicle is sent call by call. Raises ValueError where it answers otherwise or not
    once a demand, TypeError where thrusts are no real numbers.
    """
    vehicle, taus, f_min, f_max = case
    many = getattr(allocator, "many", None)
    together = many or partial(one_by_one, allocator, vehicle)
    asked = taus.copy()  # a method may write into what it is given
    answers, statuses = together(asked) if f_min is None else together(asked, f_min, f_max)
    F, given = real(np.asarray(answers)), np.asarray(statuses)
    if given.dtype.kind not in "iu":
        raise TypeError(f"many() gave statuses of type {given.dtype}; give values of alloc.Status")
    status = given.astype(np.int8)
    if F.shape != (len(taus), vehicle.n) or status.shape != (len(taus),):
        raise ValueError(
            f"many() gave thrusts of shape {F.shape} and statuses of shape {status.shape}"
            f" for {len(taus)} demands on {vehicle.n} thrusters"
        )
    if brought and many:
        _hold(allocator, case, F)
    return F, status


def _hold(allocator: Allocator, case: Case, F: FloatArray) -> None:
    """Raise ValueError where single calls give other thrusts than those of ``many``, F (N, n) [N]."""
    vehicle, *columns = case
    rows = np.linspace(0, len(F) - 1, min(ASKED, len(F)), dtype=int)
    calls = [column[rows].copy() for column in columns if column is not None]
    single = np.array([allocator(*call)[0] for call in zip(*calls, strict=True)], dtype=float)
    tolerance = allocator.tolerance
    allowed = (2 * tolerance if tolerance < ANY_DISTANCE else ROUGHLY) * vehicle.f_scale
    same = (np.abs(single - F[rows]) <= allowed) | (np.isnan(single) & np.isnan(F[rows]))
    if np.count_nonzero(~same.all(axis=1)) > min(MOST_APART, len(rows) - 1):
        first = rows[(~same.all(axis=1)).argmax()]
        raise ValueError(f"many() gives demand {first} other thrusts than a call of its own")
