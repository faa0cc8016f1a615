"""Generalized inverse, f = T* tau (eq. 8-10): one matrix product, no limits."""

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    Allocation,
    FloatArray,
    Status,
    StatusArray,
    answer,
    checked,
    checked_many,
)
from alloc.vehicle import RANK_TOLERANCE, Vehicle

FORMULATION = "unlimited"


def generalized_inverse(vehicle: Vehicle) -> FloatArray:
    """(n, k) T* = H^-1 T'(T H^-1 T')^-1 (eq. 9) over the working thrusters; rows of the others are 0.

    Where T P has lost rank (T H^-1 T')^-1 does not exist; its pseudoinverse then gives the
    H-least f among those nearest to tau, in rows of T scaled to unit length.
    """
    on = vehicle.working
    norms = np.linalg.norm(vehicle.T, axis=1)
    rows = 1.0 / np.where(norms > 0, norms, 1.0)
    T = rows[:, None] * vehicle.TP[:, on]
    L = np.linalg.cholesky(vehicle.H[np.ix_(on, on)])
    # With H = L L', x = L'f has the plain norm: f = L^-T pinv(T L^-T) tau.
    inverse = np.linalg.solve(L.T, np.linalg.pinv(np.linalg.solve(L, T.T).T, rcond=RANK_TOLERANCE))
    G = np.zeros((vehicle.n, vehicle.k))
    G[on] = inverse * rows
    return G


class Linear:
    """The allocator f = G tau of any closed form without limits.

    SOLVED where T P G tau = tau; PARTIAL, with the nearest f, where a lost rank prevents it.
    """

    formulation = FORMULATION
    limited = False
    tolerance = 1e-9  # a product of well-conditioned matrices: rounding times cond(T) < 1e3

    def __init__(self, vehicle: Vehicle, G: FloatArray) -> None:
        """Prepare f = G tau, G (n, k)."""
        self.G = G
        self._zeros = np.zeros(vehicle.k)
        # (k, k) scaled part of a demand that G can't produce; None where there is none.
        missed = (np.eye(vehicle.k) - vehicle.TP @ G) / vehicle.wrench_scale[:, None]
        self._missed = missed if vehicle.rank < vehicle.k else None

    def __call__(self, tau: ArrayLike) -> Allocation:
        """Allocate one wrench (k,) [N, N m]."""
        wrench = checked(tau, self._zeros)
        f = self.G.dot(wrench)
        if self._missed is not None and np.abs(self._missed.dot(wrench)).max() > self.tolerance:
            return answer(f, Status.PARTIAL)
        return answer(f, Status.SOLVED)

    def many(self, taus: ArrayLike) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches in one matrix product."""
        wrenches = checked_many(taus, len(self._zeros))
        status = np.zeros(len(wrenches), dtype=np.int8)
        if self._missed is not None:
            status[np.abs(wrenches @ self._missed.T).max(axis=1, initial=0.0) > self.tolerance] = (
                Status.PARTIAL
            )
        return wrenches @ self.G.T, status


def build(vehicle: Vehicle) -> Linear:
    """Prepare f = T* tau for this vehicle, its H and its faults."""
    return Linear(vehicle, generalized_inverse(vehicle))
