"""What a vehicle can do after each failure, and how much of that each method serves."""

from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from alloc import (
    FloatArray,
    NotApplicable,
    SolverError,
    Vehicle,
    alpha_max,
    attainable_volume,
    closed_form_volume,
    safe_share,
    uniform_demands,
    worst_fault,
)
from bench.judging.loss import relative_wrench_error
from bench.judging.question import Answers, Ask, Case, Unanswered
from bench.judging.reach import demands_of_growing_size, error_curve, planes
from bench.record import Authority, Capability, Served, Unserved

N_DEMANDS = 2000
"""Demands a share is counted on: its 95 % interval is at most 4.4 points wide."""


class Asked(NamedTuple):
    """What the methods are asked about one vehicle.

    Attributes
    ----------
    states : each fault with the vehicle that has it, and demands uniform over what it can do
    growing : demands of growing size on the whole vehicle
    """

    states: list[tuple[int | None, Case]]
    growing: Case

    @property
    def cases(self) -> list[Case]:
        """All of it, in one order."""
        return [*(case for _, case in self.states), self.growing]


def measure_capabilities(
    vehicles: Sequence[Vehicle], methods: Sequence[str], seed: int, ask: Ask, n: int = N_DEMANDS
) -> list[Capability]:
    """The capability of each vehicle, reproducible from the seed; about a second a vehicle.

    A vehicle whose thrusters have no choice at all (NotApplicable) is left out.
    """
    made: list[tuple[Capability, Asked]] = []
    for vehicle in vehicles:
        try:
            asked = _asked(vehicle, seed, n)
            made.append((_without_methods(vehicle, seed), asked))
        except NotApplicable:
            continue
    for method in methods if made else ():
        answers = iter(ask(method, [case for _, asked in made for case in asked.cases]))
        for capability, asked in made:
            _add(capability, method, asked, [next(answers) for _ in asked.cases])
    for capability, _ in made:
        capability.served.sort(key=lambda served: -1 if served.fault is None else served.fault)
    return [capability for capability, _ in made]


def _asked(vehicle: Vehicle, seed: int, n: int) -> Asked:
    faults: list[tuple[int | None, Vehicle]] = [(None, vehicle)]
    if len(vehicle.working) > 1:
        worst = worst_fault(vehicle)
        faults.append((worst, vehicle.with_fault(worst)))
    return Asked(
        [(fault, (state, uniform_demands(state, np.random.default_rng(seed), n))) for fault, state in faults],
        (vehicle, demands_of_growing_size(vehicle, np.random.default_rng(seed))),
    )


def _without_methods(vehicle: Vehicle, seed: int) -> Capability:
    return Capability(
        vehicle=vehicle.name,
        dof=list(vehicle.dof),
        authority=remaining_authority(vehicle),
        served=[],
        curves=[],
        planes=planes(vehicle, seed),
    )


def _add(capability: Capability, method: str, asked: Asked, answers: list[Answers | Unanswered]) -> None:
    """Add what a method made of its cases; one that refuses the vehicle is left out."""
    why = [said for said in answers if isinstance(said, Unanswered) and said.status != "refused"]
    if why:
        capability.unserved.append(Unserved(method=method, status=why[0].status, reason=why[0].reason))
        return
    *states, growing = answers
    for (fault, (state, taus)), said in zip(asked.states, states, strict=True):
        if isinstance(said, Answers):
            error = relative_wrench_error(state, taus, said.F)
            within = (int(np.count_nonzero(error <= share)) for share in (0.01, 0.05))
            capability.served.append(_served(fault, method, len(taus), *within))
    if isinstance(growing, Answers):
        capability.curves.append(error_curve(method, asked.growing, growing.F))


def _served(fault: int | None, method: str, n: int, within_1pct: int, within_5pct: int) -> Served:
    return Served(fault=fault, method=method, n_demands=n, within_1pct=within_1pct, within_5pct=within_5pct)


def remaining_authority(vehicle: Vehicle) -> list[Authority]:
    """What is left of the vehicle: whole first, then with each working thruster off."""
    whole = attainable_volume(vehicle)
    states = [_authority(vehicle, None, vehicle.rank, whole)]
    for thruster in map(int, vehicle.working if len(vehicle.working) > 1 else ()):
        states.append(_authority(vehicle.with_fault(thruster), thruster, vehicle.rank, whole))
    return states


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
