"""f = G tau: the allocator of every closed form without limits."""

from math import hypot

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    FLOAT64,
    LARGEST_DEMAND,
    WRENCH_TOLERANCE,
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
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, limits_of
from alloc.vehicle.condition import promised, wrench_doubt

TOLERANCE = 1e-9
"""Promised distance to T* tau, relative to the largest limit, unless rounding takes more [-]."""
TINY = 1e-300
"""In place of the size of an inverse that is zero."""


def exactly(vehicle: Vehicle) -> float:
    """Length of the largest thrusts of which rounding takes less than SOLVED lets a wrench miss [N]."""
    return float(vehicle.f_scale * WRENCH_TOLERANCE / wrench_doubt(vehicle))


def usual(vehicle: Vehicle, G: FloatArray) -> float:
    """Length up to which no demand asks G (n, k) for larger thrusts than ``exactly``, in N and N m alike."""
    return min(LARGEST_DEMAND, exactly(vehicle) / max(float(np.linalg.norm(G, 2)), TINY))


class Linear(Uncapped):
    """The allocator f = G tau of any closed form without limits.

    The status is SOLVED where T P G tau = tau. It is PARTIAL, with the nearest f, where a lost rank prevents
    that, or where T and H, or a demand far beyond any vehicle, cost so many digits that it misses a wrench by
    more than SOLVED allows.
    """

    formulation = "unlimited"
    limited = False

    def __init__(self, vehicle: Vehicle, G: FloatArray) -> None:
        """Prepare f = G tau, G (n, k)."""
        self.G = G
        self.tolerance = promised(vehicle, TOLERANCE)
        self._k = vehicle.k
        self._vehicle = vehicle
        self._limits_of_call = at_call(vehicle)
        # (k, k) map to the scaled part of a demand that G misses; None where it stays within tolerance.
        missed = (np.eye(vehicle.k) - vehicle.TP @ G) / vehicle.wrench_scale[:, None]
        met = np.abs(missed * vehicle.wrench_scale).sum(axis=1).max() <= WRENCH_TOLERANCE
        self._missed = None if met else missed
        # Square of the largest thrusts of which rounding takes less than SOLVED allows the wrench to miss.
        self._rounded = exactly(vehicle) ** 2
        self._usual = usual(vehicle, G)
        self._shape = (vehicle.k,)

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *,
        cap: float | None = None,
        volts: float | None = None,
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m]; limits are checked as any method does, and not kept."""
        if cap is not None:
            raise no_cap(self.formulation)
        if (
            type(tau) is np.ndarray
            and tau.dtype is FLOAT64
            and tau.shape == self._shape
            and hypot(*tau.tolist()) <= self._usual  # false for NaN too
        ):
            wrench, is_usual = tau, True
        else:
            wrench, is_usual = checked(tau, self._k), False
        if f_min is not None or f_max is not None:
            self._limits_of_call(f_min, f_max)
        f = self.G.dot(wrench)
        if self._missed is not None and np.abs(self._missed.dot(wrench)).max() > TOLERANCE:
            return answer(f, Status.PARTIAL)
        if not is_usual and not f.dot(f) <= self._rounded:
            return answer(f, Status.PARTIAL)
        return answer(f, Status.SOLVED)

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches in one matrix product."""
        wrenches = checked_many(taus, self._k)
        if f_min is not None or f_max is not None:
            limits_of(self._vehicle, len(wrenches), f_min, f_max)
        F = wrenches @ self.G.T
        status = np.zeros(len(wrenches), dtype=np.int8)
        if self._missed is not None:
            lost = np.abs(wrenches @ self._missed.T).max(axis=1, initial=0.0) > TOLERANCE
            status[lost] = Status.PARTIAL
        status[~((F * F).sum(axis=1) <= self._rounded)] = Status.PARTIAL
        return F, status
