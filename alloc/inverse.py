"""The generalized inverse T* of eq. 9, shared by every method that starts from it."""

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.vehicle import RANK_TOLERANCE, Vehicle


def generalized_inverse(vehicle: Vehicle) -> FloatArray:
    """(n, k) T* = H^-1 T'(T H^-1 T')^-1 (eq. 9) over the working thrusters; rows of the others are 0.

    Where T P has lost rank (T H^-1 T')^-1 does not exist; its pseudoinverse then gives the
    H-least f among those nearest to tau, in rows of T scaled to unit length.
    """
    return inverse_over(vehicle, vehicle.working)


def inverse_over(vehicle: Vehicle, on: IndexArray) -> FloatArray:
    """(n, k) generalized inverse with the thrusters ``on`` alone, as if the others were off."""
    rows = 1.0 / vehicle.row_lengths
    T = rows[:, None] * vehicle.TP[:, on]
    L = np.linalg.cholesky(vehicle.H[np.ix_(on, on)])
    # With H = L L', x = L'f has the plain norm: f = L^-T pinv(T L^-T) tau.
    inverse = np.linalg.solve(L.T, np.linalg.pinv(np.linalg.solve(L, T.T).T, rcond=RANK_TOLERANCE))
    G = np.zeros((vehicle.n, vehicle.k))
    G[on] = inverse * rows
    return G
