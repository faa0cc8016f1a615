"""The one QP standard form, and the hard and soft problems posed in it.

    minimise 1/2 x'H x + g'x   subject to   A x = b,  lb <= x <= ub

Only ``b`` depends on the demand, and ``lb`` and ``ub`` on the limits of the call. A problem handed to a
solver is non-dimensional: thrusts over the vehicle's largest limit, wrench rows turned to orthonormal
ones, so a solver's tolerance means the same on a 20 N and on a 600 kN vehicle.
"""

from dataclasses import dataclass

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class QP:
    """The part of the standard form that stays the same from demand to demand, with the vehicle's own limits.

    Attributes
    ----------
    H : (m, m) symmetric positive definite matrix of the cost
    g : (m,) linear part of the cost
    A : (p, m) matrix of the equations, of full row rank
    lb, ub : (m,) bounds, infinite where there is none
    """

    H: FloatArray
    g: FloatArray
    A: FloatArray
    lb: FloatArray
    ub: FloatArray

    @property
    def bounded(self) -> IndexArray:
        """Indices of the variables with a bound: thrusts have them, slacks don't."""
        return np.flatnonzero(np.isfinite(self.lb) | np.isfinite(self.ub))

    @property
    def one_sided(self) -> tuple[FloatArray, FloatArray]:
        """(G, h) with G x <= h for the finite bounds, upper ones first: G = [I; -I], h = [ub; -lb]."""
        upper, lower = np.isfinite(self.ub), np.isfinite(self.lb)
        eye = np.eye(len(self.g))
        return np.vstack([eye[upper], -eye[lower]]), np.concatenate([self.ub[upper], -self.lb[lower]])


@dataclass(frozen=True, eq=False)
class Posed:
    """A vehicle's allocation problem as a QP, with the linear maps between the two.

    Attributes
    ----------
    qp : the problem
    b_of_tau : (p, k) with b = b_of_tau tau
    f_scale : unit of x, so that ``f[working] = f_scale * x[:m]`` [N]
    working : (m,) thrusters that are not off
    unreachable : (k - p, k) orthonormal directions in scaled wrench that no thruster pushes, so that
        no demand with a part along them can be met
    """

    qp: QP
    b_of_tau: FloatArray
    f_scale: float
    working: IndexArray
    unreachable: FloatArray

    def scaled(self, taus: FloatArray, F: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(N, p) b and (N, m) x that stand for wrenches (N, k) and the thrusts (N, n) that answer them.

        The slack of the soft problem is the scaled T P f - tau, so A x = b holds exactly there.
        """
        B = taus @ self.b_of_tau.T
        x = F[:, self.working] / self.f_scale
        if len(self.qp.g) == x.shape[1]:
            return B, x
        return B, np.hstack([x, x @ self.qp.A[:, : x.shape[1]].T - B])


def pose_hard(vehicle: Vehicle, scaled: bool = True) -> Posed:
    """min 1/2 f'Hf s.t. T P f = tau, f_min <= f <= f_max (eq. 4-5).

    With ``scaled=False`` the numbers stay in N and N m, to show what scaling changes.
    """
    f_scale = vehicle.f_scale if scaled else 1.0
    H, lb, ub, working = _thrusts(vehicle, f_scale, scaled)
    A, b_of_tau, unreachable = _equality(vehicle, f_scale, scaled)
    qp = QP(H=H, g=np.zeros(len(H)), A=A, lb=lb, ub=ub)
    return Posed(qp=qp, b_of_tau=b_of_tau, f_scale=f_scale, working=working, unreachable=unreachable)


def pose_soft(vehicle: Vehicle, scaled: bool = True) -> Posed:
    """min 1/2 f'Hf + 1/2 s'Qs s.t. T P f = tau + s, limits (Fossen 2021, eq. 11.38 without its load term).

    x = [f; s] in units of ``f_scale``; s has no bounds, so every demand has an answer.
    """
    f_scale = vehicle.f_scale if scaled else 1.0
    H, lb, ub, working = _thrusts(vehicle, f_scale, scaled)
    k, m = vehicle.k, len(H)
    rows = 1.0 / vehicle.row_lengths if scaled else np.ones(k)
    # s is measured in the same scaled rows as b; Q follows so that the cost is unchanged.
    weight = np.abs(vehicle.H).max() if scaled else 1.0
    Q = np.diag(vehicle.slack_weights / rows**2) / weight
    zero = np.zeros((m, k))
    full_H = np.block([[H, zero], [zero.T, Q]])
    A = np.hstack([rows[:, None] * vehicle.TP[:, working], -np.eye(k)])
    free = np.full(k, np.inf)
    qp = QP(
        H=full_H,
        g=np.zeros(m + k),
        A=A,
        lb=np.concatenate([lb, -free]),
        ub=np.concatenate([ub, free]),
    )
    return Posed(
        qp=qp,
        b_of_tau=np.diag(rows / f_scale),
        f_scale=f_scale,
        working=working,
        unreachable=np.zeros((0, k)),
    )


def _thrusts(
    vehicle: Vehicle, f_scale: float, scaled: bool
) -> tuple[FloatArray, FloatArray, FloatArray, IndexArray]:
    on = vehicle.working
    H = vehicle.H[np.ix_(on, on)]
    if scaled:
        H = H / np.abs(vehicle.H).max()
    return H, vehicle.f_min[on] / f_scale, vehicle.f_max[on] / f_scale, on


def _equality(vehicle: Vehicle, f_scale: float, scaled: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    T = vehicle.TP[:, vehicle.working]
    rows = 1.0 / vehicle.row_lengths
    U, sigma, Vt = np.linalg.svd(rows[:, None] * T)
    r = vehicle.rank
    unreachable = U[:, r:].T * rows / vehicle.f_scale
    if not scaled and r == vehicle.k:
        return T, np.eye(vehicle.k), unreachable
    # Rows of Vt are orthonormal, and leave no redundant equation where rank T < k.
    return Vt[:r], (U[:, :r] / sigma[:r]).T * rows / f_scale, unreachable
