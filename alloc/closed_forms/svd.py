"""Singular value decomposition, T = U S V', whole and with a thruster off (eq. 11-17); no limits."""

from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import least_effort
from alloc.vehicle import Vehicle


class Decomposition(NamedTuple):
    """T = diag(rows)^-1 U S V' L', the decomposition of eq. 11 for any H = L L'.

    Attributes
    ----------
    U : (k, k) orthogonal
    S : (k, n) singular values on the diagonal, largest first
    V : (n, n) orthogonal
    L : (n, n) lower triangular, L L' = H; the identity in the paper
    rows : (k,) one over the length of each row of T. This factor makes newtons and newton metres
        alike, so that rank does not depend on units; U and S change with it, f does not.
    """

    U: FloatArray
    S: FloatArray
    V: FloatArray
    L: FloatArray
    rows: FloatArray


def decompose(vehicle: Vehicle) -> Decomposition:
    """The decomposition of the vehicle's T, whatever its readiness (eq. 11).

    With x = L'f the effort f'Hf is x'x, so the plain decomposition of T L'^-1 serves any H.
    """
    rows = 1.0 / vehicle.row_lengths
    L = np.asarray(np.linalg.cholesky(vehicle.H), dtype=np.float64)
    U, sigma, Vt = np.linalg.svd(np.linalg.solve(L, (rows[:, None] * vehicle.T).T).T)
    S = np.zeros((vehicle.k, vehicle.n))
    np.fill_diagonal(S, sigma)
    return Decomposition(U=U, S=S, V=Vt.T, L=L, rows=rows)


def faultless_inverse(vehicle: Vehicle) -> FloatArray:
    """(n, k) G = L'^-1 V S* U' diag(rows), all thrusters ready (eq. 12).

    S* holds 1/sigma; beyond the rank of T a sigma counts as zero and gives 0, as in a pseudoinverse.
    """
    U, S, V, L, rows = decompose(vehicle)
    sigma = S.diagonal()
    kept = np.arange(len(sigma)) < vehicle.rank  # H changes the sigma, but not the rank
    S_star = np.zeros((vehicle.n, vehicle.k))
    np.fill_diagonal(S_star, np.where(kept, 1.0, 0.0) / np.where(kept, sigma, 1.0))
    inverse: FloatArray = np.linalg.solve(L.T, V @ S_star @ U.T) * rows
    return inverse


def faulty_inverse(vehicle: Vehicle) -> FloatArray:
    """(n, k) G for thrusters off or weakened: f' from A = S V_f*, and f_k = 0 (eq. 13-16).

    V* = V'L'P (eq. 13), and V_f* is what is left of it without the columns of thrusters that are
    off. Eq. 15 prints the left inverse (A'A)^-1 A', which does not exist once more thrusters than
    degrees of freedom remain; the least effort is the right inverse A'(A A')^-1, here weighted by
    the H of the thrusters that remain. For n - 1 = k both are A^-1 (eq. 17).
    """
    U, S, V, L, rows = decompose(vehicle)
    on = vehicle.working
    A = S @ (V.T @ L.T * vehicle.readiness)[:, on]
    inverse = np.zeros((vehicle.n, vehicle.k))
    # least_effort gives the right inverse where A has full row rank, else the nearest wrench.
    inverse[on] = least_effort(A, vehicle.H[np.ix_(on, on)]) @ U.T * rows
    return inverse


def svd_inverse(vehicle: Vehicle) -> FloatArray:
    """(n, k) G of f = G tau: by section 4.1.1 if every thruster is ready, else by 4.1.2."""
    ready = bool((vehicle.readiness == 1).all())
    return faultless_inverse(vehicle) if ready else faulty_inverse(vehicle)
