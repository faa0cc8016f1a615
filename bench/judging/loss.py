"""Losses of an answer: wrench error, direction error, effort, limits. Equations only, no clock.

A thruster can't push beyond its limits whatever it is told, so errors are those of the delivered wrench,
T P clip(f, f_min, f_max); the force of one that turns goes straight to its polygon. That is what the vehicle
feels, also of a closed form that ignores the limits.
Limits are a pair f_min, f_max, each (n,) or (N, n) [N]; None stands for the vehicle's.
"""

import numpy as np

from alloc import Vehicle
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.reach.zonotope import farthest
from alloc.vehicle.azimuth import SPARE, excess, nearest_thrusts
from alloc.vehicle.geometry import unit
from bench.record import SERVED_WITHIN

Limits = tuple[FloatArray, FloatArray] | None

FLOOR = 0.01
"""Demands below 1 % of ``wrench_scale`` count as that large, and have no direction: rounding and solver
tolerances must not look like 100 % of almost nothing."""

AT_LIMIT = 1e-6
"""A thrust this near to a limit, or beyond it, counts as saturated; a share of the largest limit. Limited
methods meet the wrench within as much."""


def delivered(vehicle: Vehicle, F: FloatArray, limits: Limits = None) -> FloatArray:
    """Wrenches (N, k) that the thrusters push when told F (N, n): T P clip(f, f_min, f_max).

    Where f_min exceeds f_max, f_max counts: a thruster can't push harder than it is able to.
    """
    low, high = limits or (vehicle.f_min, vehicle.f_max)
    wrench: FloatArray = nearest_thrusts(vehicle.turning, F, low, high) @ vehicle.TP.T
    return wrench


def relative_wrench_error(
    vehicle: Vehicle, taus: FloatArray, F: FloatArray, limits: Limits = None
) -> FloatArray:
    """|T P clip(f) - tau| / |tau| (N,), Euclidean lengths in wrench_scale; NaN where f is NaN."""
    miss = np.linalg.norm((delivered(vehicle, F, limits) - taus) / vehicle.wrench_scale, axis=1)
    size = np.linalg.norm(taus / vehicle.wrench_scale, axis=1)
    error: FloatArray = miss / np.maximum(size, FLOOR)
    return error


def direction_error_deg(
    vehicle: Vehicle, taus: FloatArray, F: FloatArray, limits: Limits = None
) -> FloatArray:
    """Angle (N,) between delivered and demanded wrench, both in wrench_scale [deg].

    NaN where f is NaN, the demand is smaller than FLOOR, or nothing is delivered.
    """
    a, b = taus / vehicle.wrench_scale, delivered(vehicle, F, limits) / vehicle.wrench_scale
    size_a, size_b = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)
    directed = (size_a >= FLOOR) & (size_b > 0)
    a = a / np.where(directed, size_a, 1.0)[:, None]
    b = b / np.where(directed, size_b, 1.0)[:, None]
    # Kahan's form keeps its digits at small angles, where arccos of a cosine has none.
    angle = 2 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    degrees: FloatArray = np.where(directed, np.degrees(angle), np.nan)
    return degrees


def share_along(vehicle: Vehicle, taus: FloatArray, F: FloatArray, limits: Limits = None) -> FloatArray:
    """Share (N,) of each demand that is delivered along it, w . tau / tau . tau in wrench_scale [-].

    NaN where f is NaN or the demand is smaller than FLOOR.
    """
    a, b = taus / vehicle.wrench_scale, delivered(vehicle, F, limits) / vehicle.wrench_scale
    size = np.linalg.norm(a, axis=1)
    asked = size >= FLOOR
    share: FloatArray = np.where(asked, (a * b).sum(axis=1) / np.where(asked, size, 1.0) ** 2, np.nan)
    return share


def gets_nothing(vehicle: Vehicle, taus: FloatArray, F: FloatArray, limits: Limits = None) -> BoolArray:
    """Mask of demands (N,) that get no wrench though thrusters can push along them.

    A demand that is scaled down to what can be met gets nothing where one of its axes can't be pushed that
    way, as by a thruster that can't reverse. False where f is NaN, for demands smaller than FLOOR, and
    where thrusters push at most FLOOR of the demand along it.
    """
    a, b = taus / vehicle.wrench_scale, delivered(vehicle, F, limits) / vehicle.wrench_scale
    size = np.linalg.norm(a, axis=1)
    most = farthest(vehicle, (a / vehicle.wrench_scale) @ vehicle.TP, limits)
    can = (size >= FLOOR) & (most >= FLOOR * size**2)
    nothing: BoolArray = can & (np.linalg.norm(b, axis=1) <= WRENCH_TOLERANCE * size)
    return nothing


def effort_over_optimum(
    vehicle: Vehicle, taus: FloatArray, F: FloatArray, reference: FloatArray, limits: Limits = None
) -> FloatArray:
    """f'Hf / f*'Hf* - 1 (N,), f* the hard optimum (eq. 4-5) of the same demand [-].

    NaN unless f and f* are finite, and f lies inside the limits and meets the wrench: less thrust for
    less wrench is no saving.
    """
    effort, least = (np.einsum("ij,jk,ik->i", f, vehicle.H, f) for f in (F, reference))
    met = (np.abs(F @ vehicle.TP.T - taus) <= WRENCH_TOLERANCE * vehicle.wrench_scale).all(axis=1)
    counts = met & (_excess(vehicle, F, limits).max(axis=1) <= AT_LIMIT) & (least > 0)
    ratio: FloatArray = np.where(counts, effort, np.nan) / np.where(counts, least, 1.0) - 1
    return ratio


def loss(
    vehicle: Vehicle, taus: FloatArray, F: FloatArray, reference: FloatArray, limits: Limits = None
) -> dict[str, float | None]:
    """Losses of a method on a set of demands; None for a number that no answer gives.

    Parameters
    ----------
    taus : (N, k) demands [N, N m]
    F : (N, n) thrusts as returned, NaN rows where there is none [N]
    reference : (N, n) the hard optimum (eq. 4-5) of each demand, NaN where it has none [N]

    Returns
    -------
    answered_share : share of demands whose row of F is finite; all numbers below are about those rows
    lost_wrench_p50, _p99, _max : |delivered - tau| / |tau|, see ``relative_wrench_error`` [-]
    wrench_error_<axis>_max_N or _Nm : largest |delivered - tau| on that axis
    within_1pct_share, within_5pct_share : share of all demands delivered with at most that error
    direction_error_p50_deg, direction_error_max_deg : see ``direction_error_deg``
    effort_over_optimum_p50, _max : see ``effort_over_optimum`` [-]
    limits_violated_share : answers with a thrust beyond a limit
    thrusters_saturated_mean, _max : thrusters at or beyond a limit, of those that can move
    """
    answered = np.isfinite(F).all(axis=1)
    low, high = (
        np.broadcast_to(side, F.shape)[answered] for side in limits or (vehicle.f_min, vehicle.f_max)
    )
    taus_all, taus, F, reference = taus, taus[answered], F[answered], reference[answered]
    error = relative_wrench_error(vehicle, taus, F, (low, high))
    direction = direction_error_deg(vehicle, taus, F, (low, high))
    effort = effort_over_optimum(vehicle, taus, F, reference, (low, high))
    beyond = _excess(vehicle, F, (low, high))
    violated = (beyond.max(axis=1) > AT_LIMIT).astype(float)
    firsts = [first for first, *_ in vehicle.actuators]
    saturated = ((high > low) & (beyond >= -AT_LIMIT))[:, firsts].sum(axis=1).astype(float)
    total = max(len(taus_all), 1)
    numbers = {
        "answered_share": len(taus) / total,
        "lost_wrench_p50": _quantile(error, 0.5),
        "lost_wrench_p99": _quantile(error, 0.99),
        "lost_wrench_max": _quantile(error, 1.0),
        "within_1pct_share": float(np.count_nonzero(error <= SERVED_WITHIN)) / total,
        "within_5pct_share": float(np.count_nonzero(error <= 0.05)) / total,
        "direction_error_p50_deg": _quantile(direction, 0.5),
        "direction_error_max_deg": _quantile(direction, 1.0),
        "effort_over_optimum_p50": _quantile(effort, 0.5),
        "effort_over_optimum_max": _quantile(effort, 1.0),
        "limits_violated_share": float(violated.mean()) if violated.size else None,
        "thrusters_saturated_mean": float(saturated.mean()) if saturated.size else None,
        "thrusters_saturated_max": _quantile(saturated, 1.0),
    }
    miss = np.abs(delivered(vehicle, F, (low, high)) - taus)
    for axis, column in zip(vehicle.dof, miss.T, strict=True):
        numbers[f"wrench_error_{axis}_max_{unit(axis).replace(' ', '')}"] = _quantile(column, 1.0)
    return numbers


def _excess(vehicle: Vehicle, F: FloatArray, limits: Limits) -> FloatArray:
    """``excess`` of each component (N, n) as a share of f_scale [-]."""
    low, high = limits or (vehicle.f_min, vehicle.f_max)
    share: FloatArray = excess(vehicle.turning, F, low, high, SPARE * vehicle.f_scale) / vehicle.f_scale
    return share


def _quantile(values: FloatArray, q: float) -> float | None:
    # An observed value, not an interpolated one; NaN means that a row has no such number.
    known = values[~np.isnan(values)]
    return float(np.quantile(known, q, method="higher")) if known.size else None
