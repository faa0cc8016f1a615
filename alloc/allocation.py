"""What an allocator is, and what it answers."""

from collections.abc import Callable
from enum import IntEnum
from math import hypot, nan
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alloc.errors import DemandError

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.intp]
StatusArray = NDArray[np.int8]

LARGEST_DEMAND = 1e100
"""No entry of a demand is larger [N, N m]; up to here no product with a vehicle's numbers overflows."""

WRENCH_TOLERANCE = 1e-6
"""Largest |T P f - tau| of a SOLVED answer inside limits, relative to ``vehicle.wrench_scale`` [-]. A
thruster's curve is known to a percent at best, so this is far below what a vehicle can notice, and still
ten times what the tight settings of an iterative solver leave."""


class Status(IntEnum):
    """What an allocator says about its answer; the judge checks it."""

    SOLVED = 0
    """The wrench is met within the method's stated tolerance, inside the limits it promises."""
    PARTIAL = 1
    """``f`` is finite and inside the promised limits, but the wrench is met only in part."""
    INFEASIBLE = 2
    """No ``f`` inside the limits meets the wrench; ``f`` is all NaN."""
    NOT_CONVERGED = 3
    """The solver gave up, or its answer failed the check; ``f`` is all NaN."""


class Allocation(NamedTuple):
    """One answer.

    Attributes
    ----------
    f : (n,) thrusts [N], a fresh array; all NaN where there is no such thrust
    status : what the allocator says about ``f``
    iterations : the solver's own count, or the method's of its steps or passes; 0 where nothing is counted
    solver_s : the solver's own clock [s], NaN where it has none
    """

    f: FloatArray
    status: Status
    iterations: int = 0
    solver_s: float = nan


class Allocator(Protocol):
    """A prepared method: call it with a wrench at the control rate.

    A formulation is ``unlimited`` (eq. 6-7), ``hard`` (eq. 4-5), ``soft``, ``scaled``, or the name of
    a practical rule; answers are compared only within one.
    """

    @property
    def formulation(self) -> str:
        """Which optimum it returns."""
        ...

    @property
    def limited(self) -> bool:
        """Whether f is promised to lie inside the limits."""
        ...

    @property
    def tolerance(self) -> float:
        """Promised distance to the optimum, relative to the largest limit [-]."""
        ...

    def __call__(self, tau: ArrayLike) -> Allocation:
        """Allocate one wrench ``tau`` (k,) [N, N m]; raises DemandError for bad shape or values."""
        ...

    def many(self, taus: ArrayLike) -> tuple[FloatArray, StatusArray]:
        """Allocate ``taus`` (N, k): thrusts (N, n) [N] and statuses (N,)."""
        ...


@runtime_checkable
class TwoStage(Protocol):
    """What an allocator may offer: its two stages apart, so that a run times the second one alone."""

    def pose(self, tau: FloatArray, /) -> FloatArray:
        """Right-hand side b (p,) of the problem that a wrench ``tau`` (k,) [N, N m] asks."""
        ...

    def solve(self, b: FloatArray, /) -> object:
        """The solver's answer to b, by its binding's call and nothing else."""
        ...


@runtime_checkable
class BoundedSteps(Protocol):
    """What an allocator may offer: a bound on its work, known before it is called."""

    @property
    def worst_case_steps(self) -> int | None:
        """Elementary steps that no demand exceeds; None where this vehicle's allocator knows no bound."""
        ...


_new = tuple.__new__


def answer(f: FloatArray, status: Status, iterations: int = 0, solver_s: float = nan) -> Allocation:
    """An Allocation, made without NamedTuple's Python-level constructor (a third of its price)."""
    return _new(Allocation, (f, status, iterations, solver_s))


def checked(tau: ArrayLike, k: int) -> FloatArray:
    """``tau`` as a float64 array of shape (k,), itself where it is one.

    Raises DemandError for another shape, what is no real number, NaN, and beyond LARGEST_DEMAND. The
    last two are read off one length, which neither warns nor costs a numpy call.
    """
    try:
        wrench = np.asarray(tau)
        if wrench.dtype is not _FLOAT64:
            wrench = real(wrench)
    except (TypeError, ValueError, OverflowError) as error:
        raise DemandError(f"tau is not an array of numbers ({error}); give k = {k} of them") from None
    if wrench.shape != (k,):
        raise DemandError(f"tau has shape {wrench.shape}; this vehicle takes ({k},), one entry a DOF")
    if not hypot(*wrench.tolist()) <= LARGEST_DEMAND and not _fits(wrench).all():
        raise DemandError(f"tau {_UNFIT}")
    return wrench


def checked_many(taus: ArrayLike, k: int) -> FloatArray:
    """``taus`` as a float64 array of shape (N, k); raises DemandError as ``checked`` does."""
    try:
        wrenches = np.asarray(taus)
        if wrenches.dtype is not _FLOAT64:
            wrenches = real(wrenches)
    except (TypeError, ValueError, OverflowError) as error:
        raise DemandError(f"taus is not an array of numbers ({error}); give shape (N, {k})") from None
    if wrenches.ndim != 2 or wrenches.shape[1] != k:
        raise DemandError(f"taus has shape {wrenches.shape}; this vehicle takes (N, {k}), one row a demand")
    if not (fits := _fits(wrenches)).all():
        row = int(np.flatnonzero(~fits.all(axis=1))[0])
        raise DemandError(f"taus row {row} (counted from 0) {_UNFIT}")
    return wrenches


_FLOAT64 = np.dtype(np.float64)


def real(values: NDArray[Any]) -> FloatArray:
    """``values`` as a new float64 array; raises TypeError, ValueError or OverflowError for anything else.

    Left to itself numpy reads text, counts seconds since 1970, and drops an imaginary part with a warning.
    """
    kind = values.dtype.kind
    if kind not in "biufO":
        raise TypeError(f"{values.dtype} holds no real numbers")
    if kind == "O" and any(isinstance(value, (str, bytes)) for value in values.flat):
        raise TypeError("it holds text")
    return values.astype(np.float64)


_UNFIT = f"holds NaN, infinity or a number beyond {LARGEST_DEMAND:g}; give N and N m"


def _fits(wrenches: FloatArray) -> BoolArray:
    return np.abs(wrenches) <= LARGEST_DEMAND


def one_by_one(
    allocate: Callable[[FloatArray], Allocation], taus: ArrayLike, k: int, n: int
) -> tuple[FloatArray, StatusArray]:
    """``many`` for a method with nothing better: each row in turn, in order."""
    wrenches = checked_many(taus, k)
    F = np.empty((len(wrenches), n))
    status = np.empty(len(wrenches), dtype=np.int8)
    for i, tau in enumerate(wrenches):
        F[i], status[i], _, _ = allocate(tau)
    return F, status
