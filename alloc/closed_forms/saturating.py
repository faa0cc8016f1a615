"""The allocator of practical rules: f = T* tau where that lies inside the limits, else a rule mends it."""

from collections.abc import Callable
from typing import NamedTuple

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
    no_cap,
)
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.linear import TOLERANCE
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import SPARE, excess, fit_polygons, nearest_thrusts
from alloc.vehicle.call_limits import at_call, limits_of, one_by_one
from alloc.vehicle.condition import promised, wrench_doubt


class Bounds(NamedTuple):
    """The limits of one call: as arrays (n,), and as pairs of floats, which a loop reads faster [N]."""

    low: FloatArray
    high: FloatArray
    pairs: list[tuple[float, float]]


def bounds(low: FloatArray, high: FloatArray) -> Bounds:
    """Bounds of two arrays (n,) [N]."""
    return Bounds(low, high, list(zip(low.tolist(), high.tolist(), strict=True)))


Rule = Callable[[FloatArray, list[float], Bounds], tuple[list[float], int]]
"""(tau, T* tau as a list, limits) -> (thrusts, passes taken). Thrusts left beyond a limit are clipped
afterwards."""

RuleMany = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]
"""A rule for many demands at once: (tau (N, k), T* tau (N, n), f_min, f_max (N, n)) -> thrusts (N, n), NaN
where rounding would decide: a single call then does."""

ON_THE_LINE = (0.1, 10.0)
"""Misses, in units of what counts as met, within which rounding might decide: a single call then does."""


class Saturating(Uncapped):
    """The allocator of every practical rule; its formulation is the rule's name.

    The status is SOLVED where the thrusts, mended or not, meet the wrench; else PARTIAL. INFEASIBLE says that
    the limits of the call contradict themselves; a rule does not know whether other thrusts than its own
    would have met the wrench.
    """

    limited = True

    def __init__(
        self,
        vehicle: Vehicle,
        name: str,
        rule: Rule,
        rule_many: RuleMany | None = None,
        start: FloatArray | None = None,
        tolerance: float = EXACT_TOLERANCE,
    ) -> None:
        """Prepare T* and the rule; without ``rule_many``, ``many`` mends row by row.

        A rule that begins at another ``start`` (n, k) than T* is asked at every call, inside limits too. A
        wrench that is missed by ``tolerance`` [-] counts as met; iterating leaves more than rounding does.
        """
        self.formulation = name
        self.tolerance = promised(vehicle, TOLERANCE)
        self.G = generalized_inverse(vehicle) if start is None else start
        self._always = start is not None
        self._rule = rule
        self._rule_many = rule_many
        self._vehicle = vehicle
        self._k = vehicle.k
        self._bounds = bounds(vehicle.f_min, vehicle.f_max)
        self._limits_of_call = at_call(vehicle, held=True)
        # (k, n) and (k,): T f - tau in units in which 1 is the largest miss that counts as met.
        self._unit = 1.0 / (tolerance * vehicle.wrench_scale)
        self._T = vehicle.TP * self._unit[:, None]
        # Inside limits T* tau makes tau, unless a direction is lost, or rounding of T* takes too much of it.
        self._makes = vehicle.rank == vehicle.k and wrench_doubt(vehicle) <= tolerance

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m]; ``iterations`` are the passes of the rule."""
        if cap is not None:
            raise no_cap(self.formulation)
        wrench = checked(tau, self._k)
        limits = self._bounds
        if f_min is not None or f_max is not None:
            limits = bounds(*self._limits_of_call(f_min, f_max))
            for low, high in limits.pairs:
                if low > high:
                    return answer(np.full(len(limits.pairs), np.nan), Status.INFEASIBLE)
        f = self.G.dot(wrench)
        thrusts: list[float] = f.tolist()
        for x, (low, high) in zip(thrusts, limits.pairs, strict=True):
            if not low <= x <= high:
                break
        else:
            if not self._always:
                return answer(f, Status.SOLVED if self._makes else self._status(f, wrench))
        thrusts, passes = self._rule(wrench, thrusts, limits)
        for i, (low, high) in enumerate(limits.pairs):
            x = thrusts[i]
            if not low <= x <= high:
                thrusts[i] = low if x < low else high
        f = np.array(thrusts)
        return answer(f, self._status(f, wrench), passes)

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches: T* tau in one matrix product, then the rule for those beyond a limit."""
        wrenches = checked_many(taus, self._k)
        low, high = limits_of(self._vehicle, len(wrenches), f_min, f_max, held=True)
        F = wrenches @ self.G.T
        empty = (low > high).any(axis=1)
        mend = np.flatnonzero((self._always | ((low > F) | (high < F)).any(axis=1)) & ~empty)
        if mend.size:
            at, to = low[mend], high[mend]
            F[mend] = self._mended(wrenches[mend], F[mend], at, to).clip(at, to)
        missed = np.abs(F @ self._T.T - wrenches * self._unit).max(axis=1)
        status = np.where(missed <= 1.0, Status.SOLVED, Status.PARTIAL).astype(np.int8)
        least, most = ON_THE_LINE
        for i in np.flatnonzero(~((missed < least) | (missed > most))):
            F[i], status[i], *_ = self(wrenches[i], low[i], high[i])
        F[empty], status[empty] = np.nan, Status.INFEASIBLE
        return F, status

    def _mended(self, wrenches: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        if self._rule_many is not None:
            return self._rule_many(wrenches, F, low, high)
        rows = zip(wrenches, F, low, high, strict=True)
        return np.array([self._rule(tau, f.tolist(), bounds(a, b))[0] for tau, f, a, b in rows])

    def _status(self, f: FloatArray, wrench: FloatArray) -> Status:
        missed = self._T.dot(f) - self._unit * wrench
        return Status.SOLVED if max(map(abs, missed.tolist())) <= 1.0 else Status.PARTIAL


PolygonRule = Callable[[FloatArray, FloatArray], tuple[FloatArray, int]]
"""(tau, T* tau) -> (thrusts (n,), passes taken) where thrusters turn."""


class PolygonSaturating(Saturating):
    """The allocator of a practical rule where thrusters turn: each force goes straight to its polygon."""

    def __init__(self, vehicle: Vehicle, name: str, rule: PolygonRule) -> None:
        """Prepare T* and the rule."""
        super().__init__(vehicle, name, lambda tau, f, limits: (f, 1))
        self._polygon_rule, self._spare = rule, SPARE * vehicle.f_scale

    __call__ = Uncapped.__call__

    def allocate(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m]; ``iterations`` are the passes of the rule."""
        wrench, (low, high) = checked(tau, self._k), self._limits_of_call(f_min, f_max)
        turning, f = self._vehicle.turning, self.G.dot(wrench)
        if excess(turning, f[None], low, high, 0.0).max() <= 0.0:
            return answer(f, Status.SOLVED if self._makes else self._status(f, wrench))
        f, passes = self._polygon_rule(wrench, f)
        f = fit_polygons(turning, nearest_thrusts(turning, f[None], low, high), self._spare)[0]
        return answer(f, self._status(f, wrench), passes)

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches one after the other."""
        return one_by_one(self, self._vehicle, taus, f_min, f_max)
