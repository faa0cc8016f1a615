"""Cost of failures that nobody announces: the allocator believes the whole vehicle, a thruster does not obey.

A failure is a map from the thrust that a thruster is told to the one that it makes. Thrusts of the whole
vehicle's allocator, so changed, make the wrench that is compared with the demand. Once announced, the same
failure is a vehicle with other readiness or limits, and the allocator answers for that one.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from alloc import AllocError, Vehicle, build
from alloc.allocation import FloatArray
from alloc.vehicle.azimuth import nearest_thrusts
from bench.demands.strong import strong_demands, strong_vehicle
from bench.judging.judge import rounded
from bench.judging.loss import direction_error_deg, share_along
from bench.record import FailureCost

DEMANDS = 500
"""Demands that each failure is asked: a median share of them is within 2 to 3 points of that of all."""
METHOD = "scaled"
"""Method that is told of failures: exact where the demand can be met, and it always answers."""
HALF = 0.5
"""Strength of a thruster that is fouled, or whose supply sags [-]."""

FAILURES: dict[str, Callable[[FloatArray], FloatArray]] = {
    "off": np.zeros_like,
    "stuck": lambda f: np.roll(f, 1, axis=0),
    "half": lambda f: HALF * f,
    "reversed": np.negative,
}
"""Forces (N, c) that a failed thruster makes, of those that it is told demand by demand [N]. A stuck one
makes what it was told at the demand before; the first demand has the last one before it."""


def failed_thrusts(vehicle: Vehicle, F: FloatArray, thruster: int, failure: str) -> FloatArray:
    """Thrusts (N, n) that thrusters told F (N, n) make while one of them fails [N]."""
    own = [*vehicle.actuators[thruster]]
    made = nearest_thrusts(vehicle.turning, F, vehicle.f_min, vehicle.f_max)
    made[:, own] = FAILURES[failure](made[:, own])
    return made


def announced_thrusts(
    vehicle: Vehicle, taus: FloatArray, F: FloatArray, thruster: int, failure: str
) -> FloatArray:
    """Thrusts (N, n) made for demands (N, k) once the allocator knows of the failure [N].

    F (N, n) are the whole vehicle's, of which a stuck thruster keeps one. Raises AllocError where the method
    does not cover the vehicle with that failure.
    """
    own = [*vehicle.actuators[thruster]]
    if failure == "reversed":  # its commands change their sign, so its limits change places
        low, high = vehicle.f_min.copy(), vehicle.f_max.copy()
        low[own], high[own] = -high[own], -low[own]
        azimuths = tuple(replace(a, corners=-a.corners) if a.first in own else a for a in vehicle.azimuths)
        turned = replace(vehicle, f_min=low, f_max=high, azimuths=azimuths)
        return build(METHOD, turned).many(taus)[0]
    degraded = vehicle.with_fault(thruster, HALF if failure == "half" else 0.0)
    allocate = build(METHOD, degraded)
    if failure != "stuck":
        return allocate.many(taus)[0] * degraded.readiness
    made = failed_thrusts(vehicle, F, thruster, failure)[:, own]
    answers: FloatArray = allocate.many(taus - made @ vehicle.TP[:, own].T)[0]
    answers[:, own] = made
    return answers


def failure_costs(vehicle: Vehicle, method: str, taus: FloatArray, F: FloatArray) -> list[FailureCost]:
    """Costs of each failure that is not announced; F (N, n) [N] answers demands (N, k), NaN for none."""
    answered = np.isfinite(F).all(axis=1)
    taus, F = taus[answered][:DEMANDS], F[answered][:DEMANDS]
    if not len(taus) or len(vehicle.ready) < 2:
        return []
    return [
        _cost(vehicle, taus, [failed_thrusts(vehicle, F, i, failure) for i in vehicle.ready])(
            failure=failure, method=method
        )
        for failure in FAILURES
    ]


def announced_costs(vehicle: Vehicle, taus: FloatArray) -> list[FailureCost]:
    """Costs of the same failures once announced, by METHOD; empty where it does not cover the vehicle."""
    if len(vehicle.ready) < 2:
        return []
    taus, on = taus[:DEMANDS], vehicle.ready
    try:
        F = build(METHOD, vehicle).many(taus)[0]
        made = {name: [announced_thrusts(vehicle, taus, F, i, name) for i in on] for name in FAILURES}
    except AllocError:  # too many facets, or all that is left is weak
        return []
    return [
        _cost(vehicle, taus, thrusts)(failure=failure, method=METHOD, announced=True)
        for failure, thrusts in made.items()
    ]


def delivered_shares(vehicle: Vehicle, taus: FloatArray, made: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shares (N,) of demands (N, k) that thrusts made (N, n) deliver along them, and turns (N,) [deg]."""
    asked = strong_demands(vehicle, taus)
    # What is made is made: a force that is reversed lies outside a sector, and is not cut at it.
    strong = replace(strong_vehicle(vehicle), azimuths=(), names=())
    unlimited = np.full(vehicle.n, -np.inf), np.full(vehicle.n, np.inf)
    F = np.nan_to_num(made, nan=0.0)  # without an answer nothing is delivered
    shares = np.nan_to_num(share_along(strong, asked, F, unlimited), nan=1.0)  # too small for a direction
    return shares, direction_error_deg(strong, asked, F, unlimited).round(6)  # 1e-14 is rounding


def _cost(vehicle: Vehicle, taus: FloatArray, made: list[FloatArray]) -> partial[FailureCost]:
    """Numbers of a cost; ``made`` has thrusts (N, n) [N] for each working thruster's failure in turn."""
    shares, turned = zip(*(delivered_shares(vehicle, taus, F) for F in made), strict=True)
    known = [angles[~np.isnan(angles)] for angles in turned]
    return partial(
        FailureCost,
        n_demands=len(taus),
        thrusters=vehicle.ready,
        share_p50=[rounded(np.median(share)) for share in shares],
        share_min=[rounded(share.min()) for share in shares],
        turned_p50_deg=[rounded(np.median(each)) if each.size else None for each in known],
        turned_max_deg=[rounded(each.max()) if each.size else None for each in known],
        worst=[list(map(rounded, taus[share.argmin()].tolist())) for share in shares],
    )
