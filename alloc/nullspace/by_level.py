"""Allocator that goes as far towards the demand as the limits allow, at least effort."""

from math import inf, nan
from operator import le

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    EXACT_TOLERANCE,
    Allocation,
    FloatArray,
    Status,
    StatusArray,
    answer,
    checked,
    checked_many,
)
from alloc.formulations import Formulation
from alloc.nullspace.allocator import exact
from alloc.reach.edge import start
from alloc.reach.way import Departure
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, limits_of

LOST = (0.0, 1e-9, 1e-6, 1e-3, 0.1, 1.0)
"""Shares of a way that are left out in turn where no thrusts are found for its end."""
HALVINGS = 20
"""Number of halvings towards the share before, where no thrusts were found for the next one."""


class ByLevel:
    """The allocator of a formulation with a way: SOLVED where all of the demand is delivered, else PARTIAL.

    A weak direction (``Vehicle.weak``) is left out as one that no thruster pushes: answers are those of
    ``Vehicle.strong``, and ``Allocation.residual`` has what their thrusts make along weak directions.
    ``Allocation.share`` has what was delivered of each level, 0 … 1. INFEASIBLE says that the limits of the
    call contradict themselves. Rounding may put the end of a way outside of the attainable set by its last
    digits, so the exact answer takes it as attainable, and its thrusts are moved onto the limits.
    """

    limited = True

    def __init__(self, vehicle: Vehicle, formulation: Formulation) -> None:
        """Prepare way and exact answer; raises NotApplicable where one of them is refused."""
        assert formulation.way is not None
        self.formulation = formulation.name
        self._vehicle, strong = vehicle, formulation.subject(vehicle)
        self._way = way = formulation.way(vehicle)
        self._exact = exact(strong, tolerance=inf)
        self._leaves_out = strong is not vehicle
        self._none = np.zeros(vehicle.k)
        self._none.setflags(write=False)
        self.tolerance = self._exact.tolerance
        self._strong, self._limits_of_call = strong, at_call(strong, held=True)
        self._own = way.departure(vehicle.f_min, vehicle.f_max)
        self._limits = list(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True))
        self._all, self._nothing = (1.0,) * len(way.keep), (0.0,) * len(way.keep)
        # (k, n) and (k,): T f - tau in units in which 1 is the largest miss that counts as met.
        self._unit = 1.0 / (EXACT_TOLERANCE * strong.wrench_scale)
        self._T = strong.TP * self._unit[:, None]

    def __call__(
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
        f, found, steps, *_ = self._exact.within(end, limits)
        if found is not Status.SOLVED:
            return self._back(wrench, begin, share, limits)
        if min(share) == 1.0:
            missed = self._T.dot(f) - self._unit * wrench
            if missed.dot(missed) <= 1.0:  # the Euclidean norm is never below the largest entry
                return answer(f, Status.SOLVED, steps, share=share, residual=self._residual(f, end))
        return answer(f, Status.PARTIAL, steps, share=share, residual=self._residual(f, end))

    def _residual(self, f: FloatArray, end: FloatArray) -> FloatArray:
        if not self._leaves_out:
            return self._none
        made: FloatArray = self._vehicle.TP.dot(f) - end
        return made

    def _back(
        self,
        wrench: FloatArray,
        begin: Departure,
        share: tuple[float, ...],
        limits: list[tuple[float, float]],
    ) -> Allocation:
        """The answer where no thrusts are found for the end of the way: for as much of it as they are."""
        best = answer(start(*np.array(limits).T), Status.PARTIAL, share=self._nothing, residual=self._none)

        def reached(lost: float) -> bool:
            nonlocal best
            less = np.array([share]) * (1.0 - lost)
            end = self._way.delivered(wrench[None], begin, less)[0]
            f, found, steps, *_ = self._exact.within(end, limits)
            if found is Status.SOLVED:
                shares = tuple(less[0].tolist())
                best = answer(f, Status.PARTIAL, steps, share=shares, residual=self._residual(f, end))
            return found is Status.SOLVED

        high = next(i for i in range(1, len(LOST)) if LOST[i] == 1.0 or reached(LOST[i]))
        none, some = LOST[high - 1], LOST[high]
        for _ in range(HALVINGS):
            middle = 0.5 * (none + some)
            none, some = (none, middle) if reached(middle) else (middle, some)
        return best

    def many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches, all demands side by side; limits (n,) or (N, n) [N]."""
        wrenches = checked_many(taus, self._vehicle.k)
        lows, highs = limits_of(self._strong, len(wrenches), f_min, f_max, held=True)
        possible = (lows <= highs).all(axis=1)
        highs = np.maximum(lows, highs)  # where they contradict themselves the answer is NaN anyhow
        begin = self._own if f_min is None and f_max is None else self._way.departure(lows, highs)
        ends, shares = self._way.towards_many(wrenches, begin)
        F, excess = self._exact.many_within(ends, lows, highs)
        met = (shares == 1.0).all(axis=1)
        met &= np.linalg.norm(F @ self._T.T - wrenches * self._unit, axis=1) <= 1.0
        for i in np.flatnonzero(possible & (excess > 1.0)):
            F[i], one, *_ = self(wrenches[i], lows[i], highs[i])
            met[i] = one is Status.SOLVED
        F[~possible] = nan
        status = np.where(met, Status.SOLVED, Status.PARTIAL)
        status[~possible] = Status.INFEASIBLE
        return F, status.astype(np.int8)
