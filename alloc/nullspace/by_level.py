"""Allocators that go as far towards the demand as the limits allow, at least effort."""

from collections.abc import Callable, Sequence
from math import inf, nan
from operator import le
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    EXACT_TOLERANCE,
    Allocation,
    FloatArray,
    Status,
    StatusArray,
    Uncapped,
    answer,
    checked,
    checked_many,
)
from alloc.formulations import Formulation, Part, mixed
from alloc.nullspace.allocator import exact
from alloc.nullspace.structure import decompose
from alloc.reach.edge import start
from alloc.reach.way import at_rest
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, limits_of

LOST = (0.0, 1e-9, 1e-6, 1e-3, 0.1, 1.0)
"""Shares of a way that are left out in turn where no thrusts are found for its end."""
HALVINGS = 20
"""Number of halvings towards the share before, where no thrusts were found for the next one."""


class Exact(Protocol):
    """Least effort for a wrench within a vehicle's limits: ``alloc.nullspace.allocator``, or another's."""

    G: FloatArray
    tolerance: float

    @property
    def closed_form(self) -> Callable[[FloatArray], FloatArray]:
        """Thrusts (n,) without limits of a wrench (k,)."""
        ...

    def solve(self, wrench: FloatArray, limits: list[tuple[float, float]]) -> Allocation:
        """Allocate a wrench (k,) within limits; SOLVED where it is missed by EXACT_TOLERANCE at most."""
        ...

    def solve_many(
        self, wrenches: FloatArray, lows: FloatArray, highs: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Thrusts (N, n) of wrenches (N, k), and excess over limits (N,): above 1 where none are found."""
        ...


def by_steps(vehicle: Vehicle) -> Exact:
    """The exact answer, of wrenches that are attainable but for rounding; raises NotApplicable."""
    return exact(vehicle, tolerance=inf)


def allocator(
    vehicle: Vehicle, formulation: Formulation, make: Callable[[Vehicle], Exact] = by_steps
) -> "ByLevel | Mixed":
    """The allocator of a formulation with a way, and of what ``make`` finds the thrusts at its end.

    Raises NotApplicable where a way or its end is refused.
    """
    parts = [ByLevel(vehicle, part, formulation.name, make) for part in formulation.parts(vehicle)]
    return parts[0] if len(parts) == 1 else Mixed(vehicle, parts)


class ByLevel(Uncapped):
    """The allocator of one way: SOLVED where all of the demand's strong part is delivered, else PARTIAL.

    A weak direction (``Vehicle.weak``) is left out: answers are those of the part's vehicle, and
    ``Allocation.residual`` has what their thrusts make along weak directions. What no thruster pushes at all
    is asked for in vain, which is PARTIAL. ``Allocation.share`` has what was delivered of each level, 0 … 1.
    INFEASIBLE says that the limits of the call contradict themselves. Rounding may put the end of a way
    outside of the attainable set by its last digits, so the exact answer takes it as attainable, and its
    thrusts are moved onto the limits.
    """

    limited = True

    def __init__(
        self, vehicle: Vehicle, part: Part, formulation: str, make: Callable[[Vehicle], Exact]
    ) -> None:
        """Prepare the exact answer at the way's end; raises NotApplicable where it is refused."""
        self.formulation, self.w, self.level_indices = formulation, part.w, part.level_indices
        self._vehicle, strong, way = vehicle, part.vehicle, part.way
        self._way = way
        self._exact = make(strong)
        self._leaves_out = strong is not vehicle
        self._none = np.zeros(vehicle.k)
        self._none.setflags(write=False)
        self.tolerance = self._exact.tolerance
        self.strong, self._limits_of_call = strong, at_call(strong, held=True)
        self._own = way.departure(vehicle.f_min, vehicle.f_max)
        self._limits = list(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True))
        self._all, self._nothing = (1.0,) * len(way.keep), (0.0,) * len(way.keep)
        # (k, n) and (k,): T f - tau in units in which 1 is the largest miss that counts as met.
        self._unit = 1.0 / (EXACT_TOLERANCE * strong.wrench_scale)
        self._T = strong.TP * self._unit[:, None]
        self._lost: FloatArray | None = None
        if strong.rank < vehicle.rank:  # the wrench that is met is another than the demand
            self._lost = decompose(vehicle).unreachable / EXACT_TOLERANCE

    def allocate(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within the limits of the call (n,) [N]."""
        wrench = checked(tau, self._vehicle.k)
        begin, limits = self._own, self._limits
        if f_min is not None or f_max is not None:
            lows, highs = self._limits_of_call(f_min, f_max)
            if not all(map(le, lows.tolist(), highs.tolist())):
                return answer(
                    np.full(self._vehicle.n, nan), Status.INFEASIBLE, share=self._nothing, residual=self._none
                )
            begin, limits = (
                self._way.departure(lows, highs),
                list(zip(lows.tolist(), highs.tolist(), strict=True)),
            )
        if self._way.direct:
            f = self._exact.G.dot(wrench)
            for x, (low, high) in zip(f.tolist(), limits, strict=True):
                if not low <= x <= high:
                    break
            else:
                return answer(f, Status.SOLVED, self._vehicle.n, share=self._all, residual=self._none)
        end, share = self._way.towards(wrench, begin)
        f, found, steps, *_ = self._exact.solve(end, limits)
        if found is not Status.SOLVED:
            return self._back(wrench, share, limits)
        if min(share) == 1.0:
            lost = self._lost
            missed = self._T.dot(f) - self._unit * wrench if lost is None else lost.dot(wrench)
            if missed.dot(missed) <= 1.0:  # the Euclidean norm is never below the largest entry
                return answer(f, Status.SOLVED, steps, share=share, residual=self._residual(f, end))
        return answer(f, Status.PARTIAL, steps, share=share, residual=self._residual(f, end))

    @property
    def levels(self) -> int:
        """Number of shares of an answer."""
        return len(self._way.keep)

    @property
    def goes_straight(self) -> bool:
        """True where no level stops before the edge: inside limits, thrusts are those without any."""
        return self._way.goes_straight

    def unlimited(self, wrench: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Thrusts (n,) [N] and residual (k,) of a wrench (k,), if there were no limits."""
        end = self._way.pushed(wrench)
        f = self._exact.closed_form(end)
        return f, self._residual(f, end)

    def path(
        self, wrench: FloatArray, low: FloatArray, high: FloatArray
    ) -> Callable[[tuple[float, ...]], Allocation | None]:
        """A function of shares that returns the answer which delivers so much; None where none is found."""
        begin = self._way.departure(low, high)
        limits = list(zip(low.tolist(), high.tolist(), strict=True))

        def reached(shares: tuple[float, ...]) -> Allocation | None:
            end = self._way.delivered(wrench[None], begin, np.array([shares]))[0]
            f, found, steps, *_ = self._exact.solve(end, limits)
            if found is not Status.SOLVED:
                return None
            return answer(f, Status.PARTIAL, steps, share=shares, residual=self._residual(f, end))

        return reached

    def _residual(self, f: FloatArray, end: FloatArray) -> FloatArray:
        if not self._leaves_out:
            return self._none
        made: FloatArray = self._vehicle.TP.dot(f) - end
        return made

    def _back(
        self, wrench: FloatArray, share: tuple[float, ...], limits: list[tuple[float, float]]
    ) -> Allocation:
        """The answer where no thrusts are found for the end of the way: for as much of it as they are."""
        low, high = np.array(limits).T
        f0 = at_rest(self.strong) if self.strong.azimuths else start(low, high)
        best = answer(f0, Status.PARTIAL, share=self._nothing, residual=self._none)
        path = self.path(wrench, low, high)
        if self.strong.azimuths:
            best = path(self._nothing) or best

        def reached(lost: float) -> bool:
            nonlocal best
            if (found := path(tuple(one * (1.0 - lost) for one in share))) is None:
                return False
            best = found
            return True

        found = next(i for i in range(1, len(LOST)) if LOST[i] == 1.0 or reached(LOST[i]))
        none, some = LOST[found - 1], LOST[found]
        for _ in range(HALVINGS):
            middle = 0.5 * (none + some)
            none, some = (none, middle) if reached(middle) else (middle, some)
        return best

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches, all demands side by side; limits (n,) or (N, n) [N]."""
        wrenches = checked_many(taus, self._vehicle.k)
        lows, highs = limits_of(self.strong, len(wrenches), f_min, f_max, held=True)
        possible = (lows <= highs).all(axis=1)
        highs = np.maximum(lows, highs)  # where they contradict themselves the answer is NaN anyhow
        begin = self._own if f_min is None and f_max is None else self._way.departure(lows, highs)
        ends, shares = self._way.towards_many(wrenches, begin)
        F, excess = self._exact.solve_many(ends, lows, highs)
        met = (shares == 1.0).all(axis=1)
        if self._lost is None:
            met &= np.linalg.norm(F @ self._T.T - wrenches * self._unit, axis=1) <= 1.0
        else:
            met &= np.linalg.norm(wrenches @ self._lost.T, axis=1) <= 1.0
        for i in np.flatnonzero(possible & (excess > 1.0)):
            F[i], one, *_ = self(wrenches[i], lows[i], highs[i])
            met[i] = one is Status.SOLVED
        F[~possible] = nan
        status = np.where(met, Status.SOLVED, Status.PARTIAL)
        status[~possible] = Status.INFEASIBLE
        return F, status.astype(np.int8)


class Mixed(Uncapped):
    """The allocator of several ways whose answers are mixed: see ``Formulation.parts``.

    Shares and residuals are mixed as thrusts are, so that they say what these make. SOLVED says that each
    part is SOLVED.
    """

    limited = True

    def __init__(self, vehicle: Vehicle, parts: Sequence[ByLevel]) -> None:
        """Wrap the allocators of the parts, in the order of ``Formulation.parts``."""
        self.parts, self._ws = parts, [part.w for part in parts]
        self._vehicle, self._limits_of_call = vehicle, at_call(vehicle.strong, held=True)
        self.formulation = parts[0].formulation
        self.tolerance, self.levels = max(part.tolerance for part in parts), parts[0].levels

    def allocate(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within the limits of the call (n,) [N]."""
        return self.mix([part(tau, f_min, f_max) for part in self.parts], f_min, f_max)

    def mix(
        self, answers: Sequence[Allocation], f_min: ArrayLike | None, f_max: ArrayLike | None
    ) -> Allocation:
        """The answer that those of the parts make, within the limits of the call (n,) [N]."""
        worst = max(answers, key=lambda one: one.status)  # INFEASIBLE is above PARTIAL, SOLVED below
        if worst.status == Status.INFEASIBLE:
            return worst
        share = mixed(
            [np.array(one.share)[part.level_indices] for one, part in zip(answers, self.parts, strict=True)],
            self._ws,
        )
        return answer(
            np.clip(mixed([one.f for one in answers], self._ws), *self._limits_of_call(f_min, f_max)),
            worst.status,
            sum(one.iterations for one in answers),
            share=tuple(share.tolist()),
            residual=mixed([np.asarray(one.residual) for one in answers], self._ws),
        )

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches, all demands side by side; limits (n,) or (N, n) [N]."""
        answers = [part.many(taus, f_min, f_max) for part in self.parts]
        lows, highs = limits_of(self._vehicle.strong, len(answers[0][1]), f_min, f_max, held=True)
        F = np.clip(mixed([F for F, _ in answers], self._ws), lows, highs)
        return F, np.maximum.reduce([status for _, status in answers])
