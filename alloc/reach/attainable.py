"""Distance of a demand from the limits: alpha*, its label, and proof that it is beyond reach."""

from collections.abc import Callable
from enum import IntEnum
from functools import partial
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alloc.allocation import FloatArray, checked, checked_many
from alloc.closed_forms.inverse import generalized_inverse
from alloc.errors import NotApplicable, SolverError
from alloc.reach.zonotope import candidates, facets, limit_rows, zonotope
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import limits_of
from alloc.vehicle.current import checked_cap
from alloc.vehicle.degeneracy import NOTHING
from alloc.vehicle.pieces import combinations

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
    """Position of a demand: the first that holds of infeasible, boundary, inactive, active."""

    INACTIVE = 0
    """T* tau lies inside the limits, so it is the constrained optimum too."""
    ACTIVE = 1
    """Attainable, but T* tau breaks a limit: only a constrained method meets it inside the limits."""
    BOUNDARY = 2
    """|alpha* - 1| within the band: on the edge of what the thrusters can do."""
    INFEASIBLE = 3
    """No thrust inside the limits gives this wrench."""


class Margins(NamedTuple):
    """Margins of N demands to the limits.

    Attributes
    ----------
    label : (N,) values of Label
    alpha : (N,) alpha*, see ``alpha_max`` [-]
    clearance_N : (N,) smallest distance of T* tau to a limit, negative where it breaks one [N]
    """

    label: NDArray[np.int8]
    alpha: FloatArray
    clearance_N: FloatArray


def alpha_max(
    vehicle: Vehicle,
    taus: ArrayLike,
    f_min: ArrayLike | None = None,
    f_max: ArrayLike | None = None,
    *,
    cap: float | None = None,
    volts: float | None = None,
) -> FloatArray:
    """alpha* = max {alpha : T P f = alpha tau, f_min <= f <= f_max} for each demand, exactly.

    The ray through tau leaves the attainable set at alpha* tau, so alpha* is the least support(c) / c'tau
    over the facets with c'tau > 0. It is inf for tau = 0, 0 for a demand with a part in a direction that no
    thruster pushes, and -inf where no multiple of tau is attainable at all (possible only if zero
    thrust lies outside the limits).

    Parameters
    ----------
    taus : (N, k) demands [N, N m]
    f_min, f_max : limits of all demands (n,), or of each (N, n) [N]; left out, the vehicle's
    cap, volts : most current of all thrusters together [A], and the voltage of the currents [V]

    Returns
    -------
    (N,) alpha* [-]
    """
    return alpha_range(vehicle, taus, f_min, f_max, cap=cap, volts=volts)[1]


def alpha_range(
    vehicle: Vehicle,
    taus: ArrayLike,
    f_min: ArrayLike | None = None,
    f_max: ArrayLike | None = None,
    *,
    cap: float | None = None,
    volts: float | None = None,
    start: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Least and largest alpha (N,) with alpha tau attainable; (inf, -inf) where there is none.

    With a wrench ``start`` (k,) [N, N m] it is start + alpha tau, within the vehicle's own limits.
    If zero thrust lies inside the limits, the least is <= 0, and tau is attainable where alpha* >= 1. If
    not, tau is attainable where alpha* >= 1 and the least is <= 1. Limits and cap are as in ``alpha_max``;
    where f_min exceeds f_max there is no alpha. Under a cap each takes a linear program. Where sets of forces
    have several convex pieces these are the ends of a union, which may have gaps; ``label`` sees them.
    """
    demands = checked_many(taus, vehicle.k)
    if (each := combinations(vehicle))[0] is not vehicle:
        limits_of(vehicle, len(demands), f_min, f_max)  # none but the vehicle's own
        found = [alpha_range(one, demands, start=start) for one in each]
        return np.minimum.reduce([low for low, _ in found]), np.maximum.reduce([high for _, high in found])
    if cap is not None:
        rows = list(zip(demands, *limits_of(vehicle, len(demands), f_min, f_max), strict=True))
        ends = [
            [alpha_max_lp(vehicle, sign * tau, *bounds, cap=cap, volts=volts) for tau, *bounds in rows]
            for sign in (-1.0, 1.0)
        ]
        return -np.array(ends[0]), np.array(ends[1])
    if f_min is not None or f_max is not None:
        limits = limits_of(vehicle, len(demands), f_min, f_max)
        if not vehicle.azimuths:  # theirs are the vehicle's own
            return _range_within(vehicle, demands, *limits)
    if candidates(vehicle) > FACETS:
        low = [-alpha_max_lp(vehicle, -tau, start=start) for tau in demands]
        return np.array(low), np.array([alpha_max_lp(vehicle, tau, start=start) for tau in demands])
    z = zonotope(vehicle)
    support = z.support if start is None else z.support - z.facets @ (start / z.scale)
    return _range(demands / z.scale, z.facets, support[None], z.tolerance)


def _range_within(
    vehicle: Vehicle, demands: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """``alpha_range`` of demands (N, k), each within its own limits (N, n)."""
    least, most = np.full(len(demands), np.inf), np.full(len(demands), -np.inf)
    choosing, pattern = np.unique(low < high, axis=0, return_inverse=True)
    possible = (low <= high).all(axis=1)
    for i, free in enumerate(choosing):
        rows = np.flatnonzero(possible & (pattern == i))
        if not rows.size:
            continue
        if comb(int(free.sum()), max(vehicle.rank - 1, 0)) > FACETS:
            for row in rows:
                bounds = (low[row], high[row])
                least[row] = -alpha_max_lp(vehicle, -demands[row], *bounds)
                most[row] = alpha_max_lp(vehicle, demands[row], *bounds)
            continue
        found = facets(vehicle, tuple(np.flatnonzero(free).tolist()))
        middle = (low[rows] + high[rows]) / 2 @ vehicle.TP.T / vehicle.wrench_scale @ found.half.T
        reach = (high[rows] - low[rows]) / 2 @ found.outreach.T
        support = np.hstack([middle + reach, reach - middle])
        support[np.abs(support) <= NOTHING] = 0.0
        least[rows], most[rows] = _range(
            demands[rows] / vehicle.wrench_scale,
            np.vstack([found.half, -found.half]),
            support,
            np.tile(found.tolerance, 2),
        )
    return least, most


def _range(
    t: FloatArray, normals: FloatArray, support: FloatArray, tolerance: FloatArray | float
) -> tuple[FloatArray, FloatArray]:
    """Least and largest multiple (N,) of wrenches or thrusts t with normals t <= support (1 or N, M)."""
    size = np.abs(t).max(axis=1)
    size[size == 0] = 1.0
    along = (t / size[:, None]) @ normals.T
    along[np.abs(along) <= tolerance] = 0.0
    # The multiple of a demand of 1e-310 N overflows to infinity.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = support / along
        high = np.where(along > 0, ratio, np.inf).min(axis=1) / size
        low = np.where(along < 0, ratio, -np.inf).max(axis=1) / size
    missed = ((along == 0) & (support < 0)).any(axis=1) | (low > high + NOTHING * np.abs(high))
    low[missed], high[missed] = np.inf, -np.inf
    return low, high


def closed_form_range(
    vehicle: Vehicle, taus: ArrayLike, start: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Least and largest alpha for which f = T* (start + alpha tau) (eq. 8) lies inside the limits, (N,) each.

    ``start`` (k,) is 0 where left out [N, N m]. (inf, -inf) where there is none; (0, 0) for a demand with a
    part that no thruster pushes, if zero is met.
    """
    G, rows = generalized_inverse(vehicle), limit_rows(vehicle)
    reach = rows.reach if start is None else rows.reach - rows.A @ (G @ start)
    low, high = _range(checked_many(taus, vehicle.k) @ G.T, rows.A, reach[None], NOTHING)
    if vehicle.rank < vehicle.k:  # thrusts T* tau inside the limits need not push tau
        least, most = alpha_range(vehicle, taus, start=start)
        low, high = np.maximum(low, least), np.minimum(high, most)
        missed = low > high
        low[missed], high[missed] = np.inf, -np.inf
    return low, high


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


def label(
    vehicle: Vehicle,
    taus: ArrayLike,
    band: float = BAND,
    f_min: ArrayLike | None = None,
    f_max: ArrayLike | None = None,
    *,
    cap: float | None = None,
    volts: float | None = None,
) -> Margins:
    """Label of each demand (N, k), with the margins that decide it.

    A demand is infeasible where alpha* < 1 - band; else boundary where |alpha* - 1| <= band; else
    inactive where T* tau lies inside the limits, and its current within the cap, active where it does not.
    Limits and cap are as in ``alpha_max``. Of several combinations of convex pieces the first label counts
    that one of them has, and the largest margins.
    """
    demands = checked_many(taus, vehicle.k)
    if (each := combinations(vehicle))[0] is not vehicle:
        limits_of(vehicle, len(demands), f_min, f_max)  # none but the vehicle's own
        found = [label(one, demands, band) for one in each]
        first = np.minimum.reduce([one.label for one in found])
        return Margins(first, *(np.maximum.reduce([one[i] for one in found]) for i in (1, 2)))
    least, most = alpha_range(vehicle, demands, f_min, f_max, cap=cap, volts=volts)
    low, high = limits_of(vehicle, len(demands), f_min, f_max)
    f = demands @ generalized_inverse(vehicle).T
    clearance = np.minimum(high - f, f - low).min(axis=1)
    if (rows := vehicle.half_planes) is not None:
        clearance = np.minimum(clearance, (rows.reach - f @ rows.A.T).min(axis=1))
    inactive = clearance >= -INSIDE * vehicle.f_scale
    if cap is not None:
        inactive &= vehicle.draw(volts).amps(f).sum(axis=1) <= cap
    labels = np.where(inactive, Label.INACTIVE, Label.ACTIVE)
    labels[(np.abs(most - 1) <= band) | (np.abs(least - 1) <= band)] = Label.BOUNDARY
    labels[(most < 1 - band) | (least > 1 + band)] = Label.INFEASIBLE
    return Margins(labels.astype(np.int8), most, clearance)


def alpha_max_lp(
    vehicle: Vehicle,
    tau: ArrayLike,
    f_min: FloatArray | None = None,
    f_max: FloatArray | None = None,
    start: ArrayLike | None = None,
    *,
    cap: float | None = None,
    volts: float | None = None,
) -> float:
    """alpha* of one demand (k,) by its definition, a linear program (HiGHS through SciPy).

    With a wrench ``start`` (k,) [N, N m] it is the largest alpha for which start + alpha tau is attainable.
    It shares no facets with ``alpha_max``, which it checks, and is some thousand times slower. Its unknowns
    are how far each thrust goes along each straight piece of its current from f_min, one without a ``cap``,
    and alpha. Slopes rise, so no piece is taken before those that cost less. Of several combinations of
    convex pieces it is the largest.
    """
    from scipy.optimize import linprog

    if (each := combinations(vehicle))[0] is not vehicle:
        return max(alpha_max_lp(one, tau, start=start) for one in each)
    t = checked(tau, vehicle.k) / vehicle.wrench_scale
    size = float(np.abs(t).max())
    moves = size > 0.0
    direction = t / size if moves else t
    low = vehicle.f_min if f_min is None else f_min
    high = vehicle.f_max if f_max is None else f_max
    if (low > high).any():
        return -np.inf
    thruster, length, slope = np.arange(vehicle.n), high - low, np.zeros(vehicle.n)
    rows: FloatArray | None = None
    left: FloatArray | None = None
    if vehicle.half_planes is not None:
        rows = np.pad(vehicle.half_planes.A, ((0, 0), (0, 1)))
        left = (vehicle.half_planes.reach - vehicle.half_planes.A @ low) / vehicle.f_scale
    if cap is not None:
        draw = vehicle.draw(volts)  # which no vehicle has whose thrusters turn
        thruster, length, slope = draw.pieces(low, high)
        rows = np.append(slope * vehicle.f_scale, 0.0)[None]
        left = np.array([checked_cap(cap) - float(draw.amps(low).sum())])
    T = vehicle.TP / vehicle.wrench_scale[:, None]
    begin = np.zeros(vehicle.k) if start is None else checked(start, vehicle.k) / vehicle.wrench_scale
    optimum = linprog(
        np.append(np.zeros(len(slope)), -float(moves)),
        A_ub=rows,
        b_ub=left,
        A_eq=np.hstack([T[:, thruster] * vehicle.f_scale, -direction[:, None]]),
        b_eq=begin - T @ low,
        bounds=[*((0.0, far) for far in (length / vehicle.f_scale).tolist()), (None, None)],
        method="highs",
        # HiGHS accepts no tighter tolerances.
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if optimum.status == INFEASIBLE_LP:
        return -np.inf
    if optimum.status != 0 or optimum.x is None:
        raise SolverError(f"{vehicle.name}: HiGHS gave up on alpha*: {optimum.message}")
    return float(optimum.x[-1]) / size if moves else np.inf


ENUMERATED = 5_000
"""Most candidate facets that are enumerated when an allocator is built, within a tenth of a second."""

Beyond = Callable[[FloatArray, FloatArray, FloatArray], bool]
"""A function of a demand (k,) [N, N m] and the limits f_min and f_max (n,) of a call [N]: whether it is
proven that no thrusts inside these limits push that demand."""


def beyond(vehicle: Vehicle) -> Beyond:
    """Prepare the proof that a demand is infeasible, from T P, the demand and the limits of the call alone.

    Whatever the direction c, no thrusts inside the limits push further along it than

        h(c) = sum over thrusters of max(c'T_i f_min_i, c'T_i f_max_i)

    so c'tau > h(c) proves that tau is infeasible, also for a c that is rounded. Every infeasible demand has
    such a c: the normal of a facet, or the step to the demand from the nearest wrench that is attainable,
    which is taken where the facets are too many. A demand beyond the edge by rounding only is not proven so.
    Where thrusters turn the share of the demand that is attainable says it, beyond what rounding takes of it.
    """
    if vehicle.azimuths:
        return partial(_out_of_polygons, vehicle)
    scaled = vehicle.TP / vehicle.wrench_scale[:, None]
    lengths = np.linalg.norm(scaled, axis=0)
    normals: FloatArray | None = None
    if comb(len(vehicle.working), max(vehicle.rank - 1, 0)) <= ENUMERATED:
        # Facets that the set has within other limits are spanned by the same subsets of thrusters.
        half = facets(vehicle, tuple(vehicle.working.tolist())).half
        normals, along_normals = np.vstack([half, -half]), np.vstack([half, -half]) @ scaled

    def proven(tau: FloatArray, f_min: FloatArray, f_max: FloatArray) -> bool:
        t = tau / vehicle.wrench_scale
        doubt = NOTHING * (np.linalg.norm(t) + lengths @ np.maximum(np.abs(f_min), np.abs(f_max)))
        if normals is None:
            c = step_to(t, scaled, f_min, f_max)
            along, wanted = c @ scaled, np.atleast_1d(c @ t)
        else:
            along, wanted = along_normals, normals @ t
        farthest = np.maximum(along * f_min, along * f_max).sum(axis=-1)
        return bool((wanted - farthest > doubt).any())

    return proven


def _out_of_polygons(vehicle: Vehicle, tau: FloatArray, f_min: FloatArray, f_max: FloatArray) -> bool:
    least, most = alpha_range(vehicle, tau[None])
    return bool(most[0] < 1.0 - INSIDE or least[0] > 1.0 + INSIDE)


def step_to(t: FloatArray, A: FloatArray, f_min: FloatArray, f_max: FloatArray) -> FloatArray:
    """Unit step (k,) to t from the nearest A f with f_min <= f <= f_max; zero where A f = t for such an f."""
    from scipy.optimize import lsq_linear

    free = f_min < f_max
    rest: FloatArray = t - A[:, ~free] @ f_min[~free]
    if free.any():
        unit = float(np.maximum(np.abs(f_min), np.abs(f_max)).max())
        nearest = lsq_linear(A[:, free] * unit, rest, (f_min[free] / unit, f_max[free] / unit), "bvls", 1e-15)
        rest = rest - A[:, free] @ (nearest.x * unit)
    length = float(np.linalg.norm(rest))
    return rest / length if length > 0.0 else rest
