"""The optimum that keeps the direction: the largest attainable share of the wrench, at least effort."""

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import Allocation, FloatArray, Status, StatusArray, answer, checked, checked_many
from alloc.formulations.scaled import FORMULATION as SCALED
from alloc.formulations.scaled import INWARD
from alloc.nullspace.allocator import TOLERANCE, exact
from alloc.reach.attainable import alpha_max
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import limits_of

FORMULATION = SCALED.name


class Scaled:
    """The allocator: SOLVED with alpha = 1, PARTIAL with less, INFEASIBLE where none in [0, 1] is attainable.

    Where failed thrusters cost rank, the reachable part T P T* tau keeps its direction: no share of a wrench
    with a part that no thruster pushes would be attainable.
    """

    formulation = FORMULATION
    limited = True
    tolerance = TOLERANCE

    def __init__(self, vehicle: Vehicle) -> None:
        """Prepare the facets and the exact answer; raises NotApplicable where that is refused."""
        self._exact = exact(vehicle)
        self._vehicle = vehicle
        # (k, k) projection onto wrenches that the thrusters can push; None where they push every wrench.
        self._reachable = vehicle.TP @ self._exact.G if vehicle.rank < vehicle.k else None
        alpha_max(vehicle, np.zeros((1, vehicle.k)))  # the facets are made here, not in the first call

    def __call__(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m]."""
        wrench = checked(tau, self._vehicle.k)
        whole = self._exact(wrench, f_min, f_max)
        if whole.status is Status.SOLVED:
            return whole
        share = self._exact(self._shares(wrench[None], f_min, f_max)[0], f_min, f_max)
        status = Status.PARTIAL if share.status is Status.SOLVED else Status.INFEASIBLE
        return answer(share.f, status, whole.iterations + share.iterations)

    def many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches."""
        wrenches = checked_many(taus, self._vehicle.k)
        low, high = limits_of(self._vehicle, len(wrenches), f_min, f_max)
        F, status = self._exact.many(wrenches, low, high)
        rest = np.flatnonzero(status != Status.SOLVED)
        if rest.size:
            shares = self._shares(wrenches[rest], low[rest], high[rest])
            F[rest], of_share = self._exact.many(shares, low[rest], high[rest])
            status[rest] = np.where(of_share == Status.SOLVED, Status.PARTIAL, Status.INFEASIBLE)
        return F, status

    def _shares(self, wrenches: FloatArray, f_min: ArrayLike | None, f_max: ArrayLike | None) -> FloatArray:
        """(N, k) largest attainable share of each wrench; the wrench itself where no share is attainable."""
        if self._reachable is not None:
            wrenches = wrenches @ self._reachable.T
        alpha = alpha_max(self._vehicle, wrenches, f_min, f_max)
        alpha = np.where(alpha < 0, 1.0, np.minimum(alpha * (1 - INWARD), 1.0))
        return wrenches * alpha[:, None]


def build(vehicle: Vehicle) -> Scaled:
    """Prepare min f'Hf s.t. T P f = alpha tau, f_min <= f <= f_max, alpha the largest in [0, 1]."""
    return Scaled(vehicle)
