"""The optimum that keeps the direction: the largest attainable share of the wrench, at least effort."""

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import Allocation, FloatArray, Status, StatusArray, answer, checked, checked_many
from alloc.formulations.scaled import FORMULATION as SCALED
from alloc.formulations.scaled import INWARD
from alloc.nullspace.allocator import exact
from alloc.reach.attainable import alpha_max
from alloc.vehicle import Vehicle

FORMULATION = SCALED.name


class Scaled:
    """The allocator: SOLVED with alpha = 1; PARTIAL with less; INFEASIBLE where none in [0, 1] can be had.

    Where thrusters have failed and rank is lost, it is the reachable part T P T* tau that keeps its
    direction: of a wrench with a part that no thruster pushes, nothing at all would be attainable.
    """

    formulation = FORMULATION
    limited = True
    tolerance = 1e-9  # as of the exact answer behind it

    def __init__(self, vehicle: Vehicle) -> None:
        """Prepare the facets and the exact answer; raises NotApplicable where that does."""
        self._exact = exact(vehicle)
        self._vehicle = vehicle
        # (k, k) onto what the thrusters can push; None where that is everything.
        self._reachable = vehicle.TP @ self._exact.G if vehicle.rank < vehicle.k else None
        alpha_max(vehicle, np.zeros((1, vehicle.k)))  # the facets are made here, not in the first call

    def __call__(self, tau: ArrayLike) -> Allocation:
        """Allocate one wrench (k,) [N, N m]."""
        wrench = checked(tau, self._vehicle.k)
        found = self._exact(wrench)
        if found.status is Status.SOLVED:
            return found
        again = self._exact(self._shares(wrench[None])[0])
        status = Status.PARTIAL if again.status is Status.SOLVED else Status.INFEASIBLE
        return answer(again.f, status, found.iterations + again.iterations)

    def many(self, taus: ArrayLike) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches."""
        wrenches = checked_many(taus, self._vehicle.k)
        F, status = self._exact.many(wrenches)
        rest = np.flatnonzero(status != Status.SOLVED)
        if rest.size:
            F[rest], again = self._exact.many(self._shares(wrenches[rest]))
            status[rest] = np.where(again == Status.SOLVED, Status.PARTIAL, Status.INFEASIBLE)
        return F, status

    def _shares(self, wrenches: FloatArray) -> FloatArray:
        """(N, k) the largest attainable share of each wrench; the wrench itself where there is none."""
        if self._reachable is not None:
            wrenches = wrenches @ self._reachable.T
        alpha = alpha_max(self._vehicle, wrenches)
        alpha = np.where(alpha < 0, 1.0, np.minimum(alpha * (1 - INWARD), 1.0))
        return wrenches * alpha[:, None]


def build(vehicle: Vehicle) -> Scaled:
    """Prepare min f'Hf s.t. T P f = alpha tau, f_min <= f <= f_max, alpha the largest in [0, 1]."""
    return Scaled(vehicle)
