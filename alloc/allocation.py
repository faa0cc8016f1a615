"""Allocators and their results."""

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
"""Largest entry that a demand may have [N, N m]; up to it no product with a vehicle's numbers overflows."""

WRENCH_TOLERANCE = 1e-6
"""Largest |T P f - tau| of a SOLVED answer inside limits, relative to ``vehicle.wrench_scale`` [-]. A
thruster's curve is known to a percent at best, so this tolerance is far below what a vehicle can notice,
and still ten times what the tight settings of an iterative solver leave."""

EXACT_TOLERANCE = 1e-9
"""The same for methods that do not iterate [-]: what rounding leaves on nearly symmetric vehicles too, and so
the largest |T P f - (w + share Delta)| of an answer with shares."""


class Status(IntEnum):
    """Claim of an allocator about its answer; the judge checks the claim."""

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
    f : (n,) thrusts [N], a fresh array; all NaN with status INFEASIBLE or NOT_CONVERGED
    status : what the allocator claims about ``f``
    iterations : the solver's count of iterations, or the method's of steps or passes; 0 without a count
    solver_s : time by the solver's own clock [s], NaN where it has none
    share : per level, the fraction of the demand delivered, 0 … 1 [-], counting only axes that working
        thrusters push; empty for a method without levels
    residual : (k,) T P f minus the promised wrench [N, N m]: what thrusts make along weak directions; empty
        for a method without levels
    amps : (n,) current of each thruster [A]; empty for a call without a cap
    forces : (m,) force of each thruster [N], of one that turns its size; empty where none turns
    angles : (m,) of each thruster that turns, from x towards y, -180 … 180, without a force the one nearest
        to 0 that it can take [deg], NaN of others; empty where none turns
    middles : (m,) middle of the sector of each thruster that turns within one [deg], NaN of others; empty
        where none turns

    Raises TypeError where it is asked whether it is true: ``found`` and ``status`` say two different things.
    """

    f: FloatArray
    status: Status
    iterations: int = 0
    solver_s: float = nan
    share: tuple[float, ...] = ()
    residual: FloatArray | tuple[()] = ()
    amps: FloatArray | tuple[()] = ()
    forces: FloatArray | tuple[()] = ()
    angles: FloatArray | tuple[()] = ()
    middles: FloatArray | tuple[()] = ()

    def nearest_angles(self, last: ArrayLike) -> FloatArray:
        """Angles (m,) [deg] the shortest way round from the ``last`` ones (m,), by half a turn at most.

        They go on beyond 180. A thruster with a sector turns through it, never through its gap. A thruster
        without a force, or without an answer, keeps its last angle; one without a last angle, NaN, takes
        that of ``angles``, within its sector. Raises DemandError for another shape, and for infinity.
        """
        before, m = np.asarray(last, dtype=np.float64), len(self.angles)
        if before.shape != (m,) or np.isinf(before).any():
            raise DemandError(f"last has shape {before.shape}; give ({m},), a finite angle a thruster [deg]")
        known, angles, middles = ~np.isnan(before), np.asarray(self.angles), np.asarray(self.middles)
        own = middles + 360.0 * np.round(np.where(known, before - middles, 0.0) / 360.0)
        about = np.where(np.isnan(middles), before, own)
        turn = (angles - about + 180.0) % 360.0 - 180.0
        kept = np.isnan(angles) | (known & (np.asarray(self.forces) == 0.0))
        return np.where(kept, before, np.where(np.isnan(about), angles, about + turn))

    @property
    def found(self) -> bool:
        """True if ``f`` holds thrusts: with SOLVED, and with PARTIAL, which meets the wrench in part."""
        return self.status <= Status.PARTIAL

    def __bool__(self) -> bool:
        raise TypeError(
            "an Allocation is neither true nor false: ask result.found (there are thrusts), "
            "or result.status == Status.SOLVED (and they meet the demand)"
        )


class Allocator(Protocol):
    """A prepared method: call it with a wrench at the control rate.

    A formulation is ``unlimited`` (eq. 6-7), ``hard`` (eq. 4-5), ``soft``, ``scaled``, or the name of
    a practical rule; answers are compared only within one formulation.

    Every allocator of the catalogue may be called by several threads. Those around a QP solver hold a lock
    while it solves, so threads that shall solve at the same time take one allocator each; with a warm start
    the first guess is the last answer of any thread. ``pose`` and ``solve`` of ``TwoStage`` hold no lock.
    """

    @property
    def formulation(self) -> str:
        """Name of the formulation whose right answer the allocator gives."""
        ...

    @property
    def limited(self) -> bool:
        """True if the allocator promises thrusts inside the limits."""
        ...

    @property
    def tolerance(self) -> float:
        """Promised distance to the right answer, relative to the largest limit [-]."""
        ...

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> Allocation:
        """Allocate one wrench ``tau`` (k,) [N, N m] within the limits of this call, (n,) each [N].

        A limit left out is the vehicle's. Where some f_min exceeds f_max there is nothing to allocate: the
        answer of a method with limits is INFEASIBLE. Raises DemandError for bad shape or values.
        A ``cap`` on the sum of currents [A] at a voltage [V] is taken by ``scaled``, ``scaled-by-group`` and
        ``frugal``, by others refused with a DemandError; where no f within the limits meets it the answer is
        INFEASIBLE.
        """
        ...

    def many(
        self,
        taus: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate ``taus`` (N, k): thrusts (N, n) [N] and statuses (N,); limits (n,) or (N, n) [N]."""
        ...


@runtime_checkable
class TwoStage(Protocol):
    """An allocator that offers its two stages apart, so that a run can time the solver alone."""

    def pose(
        self, tau: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None, /
    ) -> tuple[FloatArray, ...]:
        """Arguments of ``solve`` for a wrench ``tau`` (k,) [N, N m] and limits (n,) [N]."""
        ...

    def solve(self, *posed: FloatArray) -> object:
        """Call the solver's binding with the result of ``pose``; nothing else is done."""
        ...


@runtime_checkable
class BoundedSteps(Protocol):
    """An allocator that offers a bound on its work, known before it is called."""

    @property
    def worst_case_steps(self) -> int | None:
        """Elementary steps that no demand exceeds; None where no bound is known for the vehicle."""
        ...


def no_cap(formulation: str) -> DemandError:
    """The refusal of a method that knows no cap on currents."""
    return DemandError(f"cap: methods for '{formulation}' take none; use scaled, scaled-by-group or frugal")


class Uncapped:
    """Base of an allocator whose calls have no cap: those with one are refused here.

    It costs a single call 35 ns. Allocators whose calls take 1 to 3 us refuse a cap there themselves.
    """

    formulation: str

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> Allocation:
        """Allocate one wrench, as ``allocate`` does; raises DemandError for a cap."""
        if cap is not None:
            raise no_cap(self.formulation)
        return self.allocate(tau, f_min, f_max)

    def many(
        self,
        taus: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate wrenches, as ``allocate_many`` does; raises DemandError for a cap."""
        if cap is not None:
            raise no_cap(self.formulation)
        return self.allocate_many(taus, f_min, f_max)

    def allocate(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits (n,) [N]."""
        raise NotImplementedError

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches within limits (n,) or (N, n) [N]."""
        raise NotImplementedError


_new = tuple.__new__


def answer(
    f: FloatArray,
    status: Status,
    iterations: int = 0,
    solver_s: float = nan,
    share: tuple[float, ...] = (),
    residual: FloatArray | tuple[()] = (),
    amps: FloatArray | tuple[()] = (),
) -> Allocation:
    """An Allocation, made without NamedTuple's slower Python-level constructor."""
    return _new(Allocation, (f, status, iterations, solver_s, share, residual, amps, (), (), ()))


def checked(tau: ArrayLike, k: int) -> FloatArray:
    """``tau`` as a float64 array of shape (k,); returns ``tau`` itself where it already is such an array.

    Raises DemandError for another shape, and for entries that are no real numbers, NaN, or larger than
    LARGEST_DEMAND. One call of hypot finds NaN and large entries; it neither warns nor costs a numpy call.
    """
    try:
        wrench = np.asarray(tau)
        if wrench.dtype is not FLOAT64:
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
        if wrenches.dtype is not FLOAT64:
            wrenches = real(wrenches)
    except (TypeError, ValueError, OverflowError) as error:
        raise DemandError(f"taus is not an array of numbers ({error}); give shape (N, {k})") from None
    if wrenches.ndim != 2 or wrenches.shape[1] != k:
        raise DemandError(f"taus has shape {wrenches.shape}; this vehicle takes (N, {k}), one row a demand")
    if not (fits := _fits(wrenches)).all():
        row = int(np.flatnonzero(~fits.all(axis=1))[0])
        raise DemandError(f"taus row {row} (counted from 0) {_UNFIT}")
    return wrenches


FLOAT64 = np.dtype(np.float64)
"""The type of every array of numbers; numpy keeps one object of it, so ``is`` tells it."""


def real(values: NDArray[Any]) -> FloatArray:
    """``values`` as a new float64 array; raises TypeError, ValueError or OverflowError for anything else.

    numpy alone would read text, take dates as counts since 1970, and drop imaginary parts with a warning.
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
