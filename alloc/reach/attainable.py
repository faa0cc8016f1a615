"""How far a demand lies from the limits: alpha*, and the label that follows from it."""

from enum import IntEnum
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alloc.allocation import FloatArray, checked, checked_many
from alloc.closed_forms.inverse import generalized_inverse
from alloc.errors import NotApplicable, SolverError
from alloc.reach.zonotope import ROUNDING, zonotope
from alloc.vehicle import Vehicle

BAND = 1e-3
"""Half width of the boundary label in alpha: within it, solvers at their default accuracy (1e-3 to 1e-6)
may in good faith call a demand solved or infeasible."""

FACETS = 50_000
"""Most candidate facets that are enumerated, within a second. With more of them, as for 32 thrusters in
6 DOF, one linear program for each demand is quicker."""

INFEASIBLE_LP = 2
"""Status with which scipy.optimize.linprog says that a problem has no solution."""

INSIDE = 1e-9
"""Thrusts over a limit by less than this share of the largest limit count as inside: rounding of T* tau
times a condition number below 1e3."""


class Label(IntEnum):
    """Where a demand lies: the first that holds of infeasible, boundary, inactive, active."""

    INACTIVE = 0
    """T* tau lies inside the limits, so it is the constrained optimum too."""
    ACTIVE = 1
    """Attainable, but T* tau breaks a limit: only a constrained method meets it inside the limits."""
    BOUNDARY = 2
    """|alpha* - 1| within the band: on the edge of what the thrusters can do."""
    INFEASIBLE = 3
    """No thrust inside the limits gives this wrench."""


class Margins(NamedTuple):
    """Where N demands lie against the limits.

    Attributes
    ----------
    label : (N,) values of Label
    alpha : (N,) alpha*, see ``alpha_max`` [-]
    clearance_N : (N,) smallest distance of T* tau to a limit, negative where it breaks one [N]
    """

    label: NDArray[np.int8]
    alpha: FloatArray
    clearance_N: FloatArray


def alpha_max(vehicle: Vehicle, taus: ArrayLike) -> FloatArray:
    """alpha* = max {alpha : T P f = alpha tau, f_min <= f <= f_max} for each demand, exactly.

    The ray through tau leaves the attainable set at alpha* tau, so alpha* is the least support(c) / c'tau
    over the facets with c'tau > 0. It is inf for tau = 0, 0 for a demand with a part in a direction that no
    thruster pushes, and -inf where no multiple of tau is attainable at all (possible only if zero
    thrust lies outside the limits).

    Parameters
    ----------
    taus : (N, k) demands [N, N m]

    Returns
    -------
    (N,) alpha* [-]
    """
    return alpha_range(vehicle, taus)[1]


def alpha_range(vehicle: Vehicle, taus: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Least and largest alpha (N,) with alpha tau attainable; (inf, -inf) where there is none.

    If zero thrust lies inside the limits, the least is <= 0, and tau is attainable where alpha* >= 1. If
    not, tau is attainable where alpha* >= 1 and the least is <= 1.
    """
    demands = checked_many(taus, vehicle.k)
    if comb(len(vehicle.working), max(vehicle.rank - 1, 0)) > FACETS:
        low = [-alpha_max_lp(vehicle, -tau) for tau in demands]
        return np.array(low), np.array([alpha_max_lp(vehicle, tau) for tau in demands])
    z = zonotope(vehicle)
    t = demands / z.scale
    size = np.abs(t).max(axis=1)
    size[size == 0] = 1.0
    along = (t / size[:, None]) @ z.facets.T
    along[np.abs(along) <= z.tolerance] = 0.0
    with np.errstate(
        divide="ignore", invalid="ignore", over="ignore"
    ):  # the multiple of 1e-310 N overflows to inf
        ratio = z.support / along
        high = np.where(along > 0, ratio, np.inf).min(axis=1) / size
        low = np.where(along < 0, ratio, -np.inf).max(axis=1) / size
    missed = ((along == 0) & (z.support < 0)).any(axis=1) | (low > high + ROUNDING * np.abs(high))
    low[missed], high[missed] = np.inf, -np.inf
    return low, high


def closed_form_range(vehicle: Vehicle, taus: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Least and largest multiple of each demand (N, k) that f = T* tau (eq. 8) meets inside the limits.

    (inf, -inf) where there is none; (0, 0) for a demand with a part that no thruster pushes, if zero is met.
    """
    f = checked_many(taus, vehicle.k) @ generalized_inverse(vehicle).T
    f[np.abs(f) < 1e-12 * np.abs(f).max(axis=1, keepdims=True, initial=0.0)] = 0.0  # rounding of T* tau
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        upper, lower = vehicle.f_max / f, vehicle.f_min / f
    high = np.where(f > 0, upper, np.where(f < 0, lower, np.inf)).min(axis=1)
    low = np.where(f > 0, lower, np.where(f < 0, upper, -np.inf)).max(axis=1)
    outside = (vehicle.f_min > 0) | (vehicle.f_max < 0)
    missed = ((f == 0) & outside).any(axis=1) | (low > high)
    if vehicle.rank < vehicle.k:  # thrusts T* tau inside the limits need not push tau
        least, most = alpha_range(vehicle, taus)
        low, high = np.maximum(low, least), np.minimum(high, most)
        missed |= low > high
    return np.where(missed, np.inf, low), np.where(missed, -np.inf, high)


def single_axis_maxima(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    """Largest wrench (k,) backward (<= 0) and forward (>= 0) along each axis alone [N, N m].

    Both are 0 for an axis that can't be pushed alone, as after a failure that costs rank. Raises
    NotApplicable where zero wrench is not attainable, since the axes meet there.
    """
    axes = np.eye(vehicle.k)
    forward, backward = alpha_max(vehicle, axes), alpha_max(vehicle, -axes)
    if np.isneginf(forward).any() or np.isneginf(backward).any():
        raise NotApplicable(
            f"{vehicle.name}: the limits do not let the wrench be zero, so no axis can be alone"
        )
    return -backward, forward


def label(vehicle: Vehicle, taus: ArrayLike, band: float = BAND) -> Margins:
    """Label of each demand (N, k), with the margins that decide it.

    A demand is infeasible where alpha* < 1 - band; else boundary where |alpha* - 1| <= band; else
    inactive where T* tau lies inside the limits, active where it does not.
    """
    taus = checked_many(taus, vehicle.k)
    low, high = alpha_range(vehicle, taus)
    f = taus @ generalized_inverse(vehicle).T
    clearance = np.minimum(vehicle.f_max - f, f - vehicle.f_min).min(axis=1)
    inactive = clearance >= -INSIDE * vehicle.f_scale
    labels = np.where(inactive, Label.INACTIVE, Label.ACTIVE)
    labels[(np.abs(high - 1) <= band) | (np.abs(low - 1) <= band)] = Label.BOUNDARY
    labels[(high < 1 - band) | (low > 1 + band)] = Label.INFEASIBLE
    return Margins(labels.astype(np.int8), high, clearance)


def alpha_max_lp(vehicle: Vehicle, tau: ArrayLike) -> float:
    """alpha* of one demand (k,) by its definition, a linear program (HiGHS through SciPy).

    It shares no facets with ``alpha_max``, which it checks, and is some thousand times slower.
    """
    from scipy.optimize import linprog

    t = checked(tau, vehicle.k) / vehicle.wrench_scale
    size = float(np.abs(t).max())
    moves = size > 0.0
    direction = t / size if moves else t
    A = np.hstack([vehicle.TP * (vehicle.f_scale / vehicle.wrench_scale[:, None]), -direction[:, None]])
    limits = np.column_stack([vehicle.f_min, vehicle.f_max]) / vehicle.f_scale
    optimum = linprog(
        np.append(np.zeros(vehicle.n), -float(moves)),
        A_eq=A,
        b_eq=np.zeros(vehicle.k),
        bounds=[*map(tuple, limits), (None, None)],
        method="highs",
        # HiGHS accepts no tighter tolerances.
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if optimum.status == INFEASIBLE_LP:
        return -np.inf
    if optimum.status != 0 or optimum.x is None:
        raise SolverError(f"{vehicle.name}: HiGHS gave up on alpha*: {optimum.message}")
    return float(optimum.x[-1]) / size if moves else np.inf
