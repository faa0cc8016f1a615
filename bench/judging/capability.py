"""What a vehicle can do after each failure, and which share of it each method serves."""

from collections.abc import Container, Iterable, Iterator
from contextlib import suppress
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from alloc import (
    Entry,
    FloatArray,
    NotApplicable,
    SolverError,
    Vehicle,
    alpha_max,
    attainable_volume,
    build,
    catalogue,
    closed_form_volume,
    load_vehicle,
    safe_share,
    uniform_demands,
    worst_fault,
)
from bench.judging.loss import relative_wrench_error
from bench.judging.reach import error_curve, planes
from bench.record.capability import Authority, Served, Worth

N_DEMANDS = 2000
"""Demands a share is counted on: its 95 % interval is at most 4.4 points wide."""

CONFIDENCE = 0.95


def closed_forms() -> list[Entry]:
    """The methods whose worth is measured here: those that call no solver and are no second build of one.

    A solver may crash or hang; it is only ever called in a worker. Its share is that of its
    formulation, and the demand set ``uniform`` tells whether it holds.
    """
    return [entry for entry in catalogue() if not entry.missing and not set("/@") & set(entry.name)]


def measure_worths(names: Iterable[str], seed: int, known: Container[str]) -> Iterator[Worth]:
    """The worth of each named vehicle that is not known yet, as it is worked out.

    A vehicle whose thrusters have no choice at all (NotApplicable) is left out.
    """
    for vehicle in map(load_vehicle, names):
        if vehicle.name not in known:
            with suppress(NotApplicable):
                yield measure_worth(vehicle, seed)


def measure_worth(vehicle: Vehicle, seed: int, n: int = N_DEMANDS) -> Worth:
    """Everything the record keeps about one vehicle; reproducible from the seed, about a second."""
    methods = closed_forms()
    states: list[tuple[int | None, Vehicle]] = [(None, vehicle)]
    if len(vehicle.working) > 1:
        worst = worst_fault(vehicle)
        states.append((worst, vehicle.with_fault(worst)))
    curves = [error_curve(vehicle, entry, np.random.default_rng(seed)) for entry in methods]
    return Worth(
        vehicle=vehicle.name,
        dof=list(vehicle.dof),
        authority=remaining_authority(vehicle),
        served=[s for fault, state in states for s in measure_served(state, fault, methods, seed, n)],
        curves=[curve for curve in curves if curve is not None],
        planes=planes(vehicle, seed),
    )


def remaining_authority(vehicle: Vehicle) -> list[Authority]:
    """What is left of the vehicle: whole first, then with each working thruster off."""
    whole = attainable_volume(vehicle)
    found = [_authority(vehicle, None, vehicle.rank, whole)]
    for thruster in map(int, vehicle.working if len(vehicle.working) > 1 else ()):
        found.append(_authority(vehicle.with_fault(thruster), thruster, vehicle.rank, whole))
    return found


def measure_served(
    vehicle: Vehicle, fault: int | None, methods: Iterable[Entry], seed: int, n: int
) -> list[Served]:
    """The share of this vehicle's attainable set that each method serves; those that refuse it left out."""
    taus = uniform_demands(vehicle, np.random.default_rng(seed), n)
    found = []
    for entry in methods:
        try:
            F, _ = build(entry.name, vehicle).many(taus)
        except NotApplicable:
            continue
        error = relative_wrench_error(vehicle, taus, F)
        found.append(
            Served(fault, entry.name, entry.formulation, n, interval(error <= 0.01), interval(error <= 0.05))
        )
    return found


def interval(hits: NDArray[np.bool_]) -> tuple[float, float, float]:
    """The share of hits and its 95 % confidence interval (Clopper & Pearson 1934): (share, low, high)."""
    from scipy.special import betaincinv

    n, count, tail = len(hits), int(np.count_nonzero(hits)), (1 - CONFIDENCE) / 2
    low = float(betaincinv(count, n - count + 1, tail)) if count else 0.0
    high = float(betaincinv(count + 1, n - count, 1 - tail)) if count < n else 1.0
    return count / n, low, high


def _authority(vehicle: Vehicle, fault: int | None, rank: int, whole: float) -> Authority:
    volume = attainable_volume(vehicle)
    sigma = np.linalg.svd(vehicle.TP / vehicle.row_lengths[:, None], compute_uv=False)
    axes = np.eye(vehicle.k)
    kept = vehicle.rank == rank
    return Authority(
        fault=fault,
        vehicle=vehicle.name,
        rank=vehicle.rank,
        condition=float(sigma[0] / sigma[rank - 1]) if kept else None,
        volume_share=volume / whole if kept and whole else 0.0,
        closed_form_share=_closed_form_share(vehicle, volume),
        safe_share=safe_share(vehicle),
        axis_min=_finite(-alpha_max(vehicle, -axes)),
        axis_max=_finite(alpha_max(vehicle, axes)),
    )


def _closed_form_share(vehicle: Vehicle, volume: float) -> float | None:
    try:
        return closed_form_volume(vehicle) / volume if volume else None
    except SolverError:
        return None


def _finite(values: FloatArray) -> list[float | None]:
    # JSON has no infinity.
    return [value if isfinite(value) else None for value in values.tolist()]
