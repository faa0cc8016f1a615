"""The allocator of practical rules: f = T* tau where that lies inside the limits, else a rule mends it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    WRENCH_TOLERANCE,
    Allocation,
    FloatArray,
    Status,
    StatusArray,
    answer,
    checked,
    checked_many,
)
from alloc.closed_forms.inverse import generalized_inverse
from alloc.vehicle import Vehicle

Rule = Callable[[FloatArray, list[float]], tuple[list[float], int]]
"""(tau, T* tau as a list) -> (thrusts, passes taken). Thrusts left beyond a limit are clipped afterwards."""

RuleMany = Callable[[FloatArray, FloatArray], FloatArray]
"""A rule for many demands at once: (tau (N, k), T* tau (N, n)) -> thrusts (N, n)."""


class Saturating:
    """The allocator of every practical rule; its formulation is the rule's name.

    The status is SOLVED where the thrusts, mended or not, meet the wrench; else PARTIAL. INFEASIBLE never
    occurs, since a rule does not know whether other thrusts would have met the wrench.
    """

    limited = True
    tolerance = 1e-9  # its own rule's arithmetic: rounding times a condition number below 1e3

    def __init__(self, vehicle: Vehicle, name: str, rule: Rule, rule_many: RuleMany | None = None) -> None:
        """Prepare T* and the rule; without ``rule_many``, ``many`` mends row by row."""
        self.formulation = name
        self.G = generalized_inverse(vehicle)
        self._rule = rule
        self._rule_many = rule_many
        self._k = vehicle.k
        self._f_min, self._f_max = vehicle.f_min, vehicle.f_max
        self._limits = list(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True))
        # (k, n) and (k,): T f - tau in units in which 1 is the largest miss that counts as met.
        self._unit = 1.0 / (WRENCH_TOLERANCE * vehicle.wrench_scale)
        self._T = vehicle.TP * self._unit[:, None]
        self._full_rank = vehicle.rank == vehicle.k

    def __call__(self, tau: ArrayLike) -> Allocation:
        """Allocate one wrench (k,) [N, N m]; ``iterations`` are the passes of the rule."""
        wrench = checked(tau, self._k)
        f = self.G.dot(wrench)
        thrusts: list[float] = f.tolist()
        for x, (low, high) in zip(thrusts, self._limits, strict=True):
            if not low <= x <= high:
                break
        else:
            return answer(f, Status.SOLVED if self._full_rank else self._status(f, wrench))
        thrusts, passes = self._rule(wrench, thrusts)
        for i, (low, high) in enumerate(self._limits):
            x = thrusts[i]
            if not low <= x <= high:
                thrusts[i] = low if x < low else high
        f = np.array(thrusts)
        return answer(f, self._status(f, wrench), passes)

    def many(self, taus: ArrayLike) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches: T* tau in one matrix product, then the rule for those beyond a limit."""
        wrenches = checked_many(taus, self._k)
        F = wrenches @ self.G.T
        mend = np.flatnonzero(((self._f_min > F) | (self._f_max < F)).any(axis=1))
        if mend.size:
            F[mend] = self._mended(wrenches[mend], F[mend]).clip(self._f_min, self._f_max)
        missed = np.abs(F @ self._T.T - wrenches * self._unit).max(axis=1)
        return F, np.where(missed <= 1.0, Status.SOLVED, Status.PARTIAL).astype(np.int8)

    def _mended(self, wrenches: FloatArray, F: FloatArray) -> FloatArray:
        if self._rule_many is not None:
            return self._rule_many(wrenches, F)
        return np.array([self._rule(wrench, f.tolist())[0] for wrench, f in zip(wrenches, F, strict=True)])

    def _status(self, f: FloatArray, wrench: FloatArray) -> Status:
        missed = self._T.dot(f) - self._unit * wrench
        return Status.SOLVED if max(map(abs, missed.tolist())) <= 1.0 else Status.PARTIAL
