"""The one QP standard form, and the hard and soft problems posed in it.

    minimise 1/2 x'H x + g'x   subject to   A x = b,  lb <= x <= ub,  C x <= d

Only ``b`` depends on the demand, and ``lb`` and ``ub`` on the limits of the call; C and d are the sides of
polygons, where thrusters turn. A problem handed to a solver is non-dimensional: thrusts over the vehicle's
largest limit, wrench rows turned to orthonormal ones, so a solver's tolerance means the same on a 20 N and on
a 600 kN vehicle. A thrust that costs more has a smaller unit, which evens the weights of H out and takes the
limits apart.
"""

from dataclasses import dataclass

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import NotApplicable
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import refuse_azimuths

SHARED = 1 / 3
"""Power of a weight by which the unit of its thrust is smaller [-]. Weights r apart leave r^(1 - 2 SHARED) in
H and r^SHARED in limits: with a third both are r^(1/3), so 1e8 become 500. With a half H would be even, and
limits 1e4 apart, which absolute tolerances of solvers do not reach; docs/solvers.md has what each costs."""


@dataclass(frozen=True, eq=False)
class QP:
    """The part of the standard form that stays the same from demand to demand, with the vehicle's own limits.

    Attributes
    ----------
    H : (m, m) symmetric positive definite matrix of the cost
    g : (m,) linear part of the cost
    A : (p, m) matrix of the equations, of full row rank
    lb, ub : (m,) bounds, infinite where there is none
    sides : C (r, m) and d (r,); None where there is none
    """

    H: FloatArray
    g: FloatArray
    A: FloatArray
    lb: FloatArray
    ub: FloatArray
    sides: tuple[FloatArray, FloatArray] | None = None

    @property
    def bounded(self) -> IndexArray:
        """Indices of the variables with a bound: thrusts have them, slacks don't."""
        return np.flatnonzero(np.isfinite(self.lb) | np.isfinite(self.ub))

    @property
    def one_sided(self) -> tuple[FloatArray, FloatArray]:
        """(G, h) with G x <= h, upper bounds, lower ones, sides: G = [I; -I; C], h = [ub; -lb; d]."""
        upper, lower = np.isfinite(self.ub), np.isfinite(self.lb)
        eye = np.eye(len(self.g))
        G, h = np.vstack([eye[upper], -eye[lower]]), np.concatenate([self.ub[upper], -self.lb[lower]])
        if self.sides is None:
            return G, h
        return np.vstack([G, self.sides[0]]), np.concatenate([h, self.sides[1]])

    @property
    def two_sided(self) -> FloatArray:
        """[I; C], rows of what bounds something on one side or both: bounds, then sides."""
        eye = np.eye(len(self.g))[self.bounded]
        return eye if self.sides is None else np.vstack([eye, self.sides[0]])

    def refuse_sides(self, solver: str) -> None:
        """Raise NotApplicable where there are sides: the file of that solver takes bounds alone."""
        if self.sides is not None:
            raise NotApplicable(f"{solver}: is asked here with bounds alone, not with sides; use qp/daqp")


@dataclass(frozen=True, eq=False)
class Posed:
    """A vehicle's allocation problem as a QP, with the linear maps between the two.

    Attributes
    ----------
    qp : the problem
    b_of_tau : (p, k) with b = b_of_tau tau
    unit : (m,) units of x, so that ``f[working] = unit * x[:m]`` [N]; the largest is ``vehicle.f_scale``
    working : (m,) thrusters that are not off
    unreachable : (k - p, k) orthonormal directions in scaled wrench that no thruster pushes, so that
        no demand with a part along them can be met
    """

    qp: QP
    b_of_tau: FloatArray
    unit: FloatArray
    working: IndexArray
    unreachable: FloatArray

    def scaled(self, taus: FloatArray, F: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(N, p) b and (N, m) x that stand for wrenches (N, k) and the thrusts (N, n) that answer them.

        The slack of the soft problem is the scaled T P f - tau, so A x = b holds exactly there.
        """
        B = taus @ self.b_of_tau.T
        x = F[:, self.working] / self.unit
        if len(self.qp.g) == x.shape[1]:
            return B, x
        return B, np.hstack([x, x @ self.qp.A[:, : x.shape[1]].T - B])


def pose_hard(vehicle: Vehicle, scaled: bool = True, shared: float = SHARED) -> Posed:
    """min 1/2 f'Hf s.t. T P f = tau, f_min <= f <= f_max (eq. 4-5).

    With ``scaled=False`` the numbers stay in N and N m, to show what scaling changes. ``shared`` is the power
    of a weight by which the unit of its thrust is smaller.
    """
    unit, H, lb, ub = _thrusts(vehicle, scaled, shared)
    A, b_of_tau, unreachable = _equality(vehicle, unit, scaled)
    qp = QP(H=H, g=np.zeros(len(H)), A=A, lb=lb, ub=ub, sides=_sides(vehicle, unit))
    return Posed(qp=qp, b_of_tau=b_of_tau, unit=unit, working=vehicle.working, unreachable=unreachable)


def pose_soft(vehicle: Vehicle, scaled: bool = True, shared: float = SHARED) -> Posed:
    """min 1/2 f'Hf + 1/2 s'Qs s.t. T P f = tau + s, limits (Fossen 2021, eq. 11.38 without its load term).

    x = [f; s], s in units of ``f_scale`` along rows of T of unit length; s has no bounds, so every demand has
    an answer.
    """
    refuse_azimuths(vehicle.azimuths, "soft", "what proves its answers knows bounds alone")
    unit, H, lb, ub = _thrusts(vehicle, scaled, shared)
    f_scale = vehicle.f_scale if scaled else 1.0
    k, m = vehicle.k, len(H)
    rows = 1.0 / vehicle.row_lengths if scaled else np.ones(k)
    # s is measured in the same scaled rows as b; Q follows so that the cost is unchanged.
    Q = np.diag(vehicle.slack_weights / rows**2) / _cheapest(vehicle, scaled)
    zero = np.zeros((m, k))
    full_H = np.block([[H, zero], [zero.T, Q]])
    A = np.hstack([rows[:, None] * vehicle.TP[:, vehicle.working] * (unit / f_scale), -np.eye(k)])
    free = np.full(k, np.inf)
    qp = QP(H=full_H, g=np.zeros(m + k), A=A, lb=np.concatenate([lb, -free]), ub=np.concatenate([ub, free]))
    return Posed(
        qp=qp,
        b_of_tau=np.diag(rows / f_scale),
        unit=unit,
        working=vehicle.working,
        unreachable=np.zeros((0, k)),
    )


def _sides(vehicle: Vehicle, unit: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Sides of polygons for x in units (m,) [N], rows of unit length; None where no thruster turns."""
    if vehicle.half_planes is None:
        return None
    C = vehicle.half_planes.A[:, vehicle.working] * unit
    lengths = np.linalg.norm(C, axis=1)
    return C / lengths[:, None], vehicle.half_planes.reach / lengths


def _cheapest(vehicle: Vehicle, scaled: bool) -> float:
    """Cost of the thruster that costs least [1/N^2], the unit of costs; 1 where nothing is scaled."""
    return float(np.diag(vehicle.H)[vehicle.working].min()) if scaled else 1.0


def _thrusts(
    vehicle: Vehicle, scaled: bool, shared: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Units of x (m,) [N], and in them H (m, m), lb and ub (m,)."""
    on = vehicle.working
    H = vehicle.H[np.ix_(on, on)]
    cheapest = _cheapest(vehicle, scaled)
    share = (cheapest / np.diag(H)) ** shared if scaled else np.ones(len(on))
    unit = share * (vehicle.f_scale if scaled else 1.0)
    H = H * np.outer(share, share) / cheapest  # symmetric to the last bit, which SIP asks for
    return unit, H, vehicle.f_min[on] / unit, vehicle.f_max[on] / unit


def _equality(vehicle: Vehicle, unit: FloatArray, scaled: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    T = vehicle.TP[:, vehicle.working]
    rows = 1.0 / vehicle.row_lengths
    U, sigma, Vt = np.linalg.svd(rows[:, None] * T)
    r = vehicle.rank
    unreachable = U[:, r:].T * rows / vehicle.f_scale
    if not scaled and r == vehicle.k:
        return T, np.eye(vehicle.k), unreachable
    # Rows of Vt are orthonormal, and leave no redundant equation where rank T < k. Where thrusts have units
    # of their own, V'unit x = b0 is turned to orthonormal rows again: unit V = Q R, so Q'x = R'^-1 b0.
    b_of_tau = (U[:, :r] / sigma[:r]).T * rows
    if (unit == unit[0]).all():
        return Vt[:r], b_of_tau / unit[0], unreachable
    Q, R = np.linalg.qr(unit[:, None] * Vt[:r].T)
    return Q.T, np.linalg.solve(R.T, b_of_tau), unreachable


class TwoSided:
    """low <= [A; I; C] x <= high, with the rows of I that bound something.

    Attributes
    ----------
    low, high : (p + q + r,) the first p are b, then q are bounds, then r those of sides
    """

    def __init__(self, qp: QP) -> None:
        """Begin with the bounds of the problem, and b = 0."""
        bounded = qp.bounded
        self._p = len(qp.A)
        self._held = qp.lb[bounded], qp.ub[bounded]
        d = np.zeros(0) if qp.sides is None else qp.sides[1]
        ends, self._bounds = (np.full(len(d), -np.inf), d), slice(self._p, self._p + len(bounded))
        self.low, self.high = (
            np.concatenate([np.zeros(self._p), side, end]) for side, end in zip(self._held, ends, strict=True)
        )

    def put(self, b: FloatArray, lb: FloatArray, ub: FloatArray) -> None:
        """Write b (p,) and the bounds (q,) of the bounded variables."""
        low, high, p = self.low, self.high, self._p
        low[:p] = high[:p] = b
        if lb is not self._held[0] or ub is not self._held[1]:
            low[self._bounds], high[self._bounds] = lb, ub
            self._held = lb, ub


class OneSided:
    """A x = b and G x <= h, with G and h of ``QP.one_sided``: [A; G] beside ``right`` = [b; h].

    Attributes
    ----------
    right : (p + g,) the first p are b, then the finite upper bounds, the negated lower ones, and d
    """

    def __init__(self, qp: QP) -> None:
        """Begin with the bounds of the problem, and b = 0."""
        bounded = qp.bounded
        self._p = len(qp.A)
        self._held = qp.lb[bounded], qp.ub[bounded]
        self._lower, self._upper = (np.flatnonzero(np.isfinite(side)) for side in self._held)
        self._middle = self._p + len(self._upper)
        self._end = self._middle + len(self._lower)
        self.right = np.concatenate([np.zeros(self._p), qp.one_sided[1]])

    def put(self, b: FloatArray, lb: FloatArray, ub: FloatArray) -> None:
        """Write b (p,) and the bounds (q,) of the bounded variables."""
        right = self.right
        right[: self._p] = b
        if lb is not self._held[0] or ub is not self._held[1]:
            right[self._p : self._middle] = ub[self._upper]
            np.negative(lb[self._lower], out=right[self._middle : self._end])
            self._held = lb, ub


@dataclass(frozen=True, eq=False, kw_only=True)
class Whitened:
    """min 1/2 y'y + g'y subject to A y = turn b, and bounds on x = back y.

    Attributes
    ----------
    g : (m,) linear part of the cost
    A : (p, m) orthonormal rows
    turn : (p, p) map of the right side b
    back : (m, m) map from y to x
    """

    g: FloatArray
    A: FloatArray
    turn: FloatArray
    back: FloatArray


def whitened(qp: QP) -> Whitened | None:
    """The problem in such variables; None where H is diagonal, and units are enough."""
    if np.array_equal(qp.H, np.diag(np.diag(qp.H))):
        return None
    back = np.linalg.inv(np.linalg.cholesky(qp.H)).T
    Q, R = np.linalg.qr((qp.A @ back).T)
    return Whitened(g=back.T @ qp.g, A=Q.T, turn=np.linalg.inv(R.T), back=back)
