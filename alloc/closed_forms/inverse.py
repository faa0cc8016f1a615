"""The generalized inverse T* of eq. 9, shared by every method that starts from it."""

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import independent


def generalized_inverse(vehicle: Vehicle) -> FloatArray:
    """(n, k) T* = H^-1 T'(T H^-1 T')^-1 (eq. 9) over the working thrusters; rows of the others are 0.

    Where T P has lost rank (T H^-1 T')^-1 does not exist; its pseudoinverse then gives the
    H-least f among those nearest to tau, in rows of T scaled to unit length.
    """
    return inverse_over(vehicle, vehicle.working)


def inverse_over(vehicle: Vehicle, on: IndexArray) -> FloatArray:
    """(n, k) generalized inverse with the thrusters ``on`` alone, as if the others were off."""
    rows = 1.0 / vehicle.row_lengths
    G = np.zeros((vehicle.n, vehicle.k))
    G[on] = least_effort(rows[:, None] * vehicle.TP[:, on], vehicle.H[np.ix_(on, on)]) * rows
    return G


def least_effort(A: FloatArray, H: FloatArray) -> FloatArray:
    """(m, k) inverse of A (k, m) that gives the least f'Hf among all f with A f nearest to the wrench.

    It is A+ - N (N'HN)^-1 N'H A+ with a basis N of null(A): the pseudoinverse less its costly part along N.
    So A f is met whatever H is, and rank depends on A alone; pinv(A L'^-1) with H = L L' loses both where H
    weighs one thruster 1e8 times another. f is the least to 1e-9 up to weights 1e8 apart, and to 1e-6 up to
    the 1e12 that a vehicle may have. Rows of A have unit length, or had before a fault.
    """
    U, sigma, Vt = np.linalg.svd(A, full_matrices=False)
    r = independent(sigma)
    plain: FloatArray = Vt[:r].T @ ((1.0 / sigma[:r])[:, None] * U[:, :r].T)
    if np.array_equal(H, np.diag(np.full(len(H), H.max(initial=0.0)))):
        return plain  # N'A+ = 0: the part along N is only rounding
    N = np.linalg.svd(A)[2][r:].T
    inverse: FloatArray = plain - N @ np.linalg.solve(N.T @ H @ N, N.T @ H @ plain)
    return inverse
