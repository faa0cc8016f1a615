"""Demands for the suite, what their answers are held against, and what came out, in figures."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocation, Allocator, Entry, Label, NotApplicable, Vehicle, alpha_max, certify_many
from alloc.allocation import FloatArray
from alloc.inverse import generalized_inverse
from alloc.qp import pose_hard, pose_soft
from bench.demands import labelled
from bench.judge import judge
from bench.reference import Question, references

N_DEMANDS = 100

LABELS = ("inactive", "active")
"""Demands that T* tau meets inside the limits, and demands that only a constrained method meets there."""


@cache
def question(vehicle: Vehicle, label: str) -> Question:
    """A path of demands of one label, with the optimum of each formulation.

    Raises NotApplicable where the vehicle has no such demands.
    """
    found = labelled(label, vehicle, {"inactive": _inactive, "active": _active}[label](vehicle))
    assert set(found.labels) == {Label[label.upper()]}
    inactive = np.equal(found.labels, Label.INACTIVE)
    optima, method = references(vehicle, found.taus, inactive, found.alpha)
    return Question(label, vehicle, found.taus, found.labels, found.alpha, None, optima, method)


def tell(
    benchmark: BenchmarkFixture,
    asked: Question,
    entry: Entry,
    allocator: Allocator,
    answers: Sequence[Allocation],
    **more: str | int,
) -> None:
    """Judge the answers that were timed, and put what they are worth into ``extra_info``.

    An answer that is not what its status says fails the test. One that lies further from the optimum
    than its solver's settings promise is an expected failure, with the distance as its reason.
    gap_rel_max is the duality gap over the cost, distance_bound_max_N the distance to the optimum
    that it proves, both without a reference; None for a formulation that is no QP.
    """
    judged = judge(
        asked,
        answers,
        formulation=allocator.formulation,
        limited=allocator.limited,
        tolerance=allocator.tolerance,
    )
    assert not judged.wrong
    gap, bound = _gap(asked, allocator.formulation, np.array([answer.f for answer in answers]))
    benchmark.extra_info.update(
        vehicle=asked.vehicle.name,
        label=asked.name,
        method=entry.name,
        formulation=allocator.formulation,
        certificate={
            "counts": judged.counts,
            "wrench_error_rel_max": judged.wrench_error_rel_max,
            "limit_violation_max_N": judged.limit_violation_max_N,
            "distance_max_N": judged.distance_max_N,
            "gap_rel_max": gap,
            "distance_bound_max_N": bound,
        },
        **more,
    )
    if judged.agrees is False:
        pytest.xfail(f"{judged.distance_max_N:.3g} N from the optimum, more than its settings promise")


def _gap(asked: Question, formulation: str, F: FloatArray) -> tuple[float | None, float | None]:
    # A closed form that stays inside the limits is the constrained optimum, so it has a gap too.
    inactive = bool((asked.labels == Label.INACTIVE).all())
    hard = formulation == "hard" or (formulation == "unlimited" and inactive)
    solved = np.isfinite(F).all(axis=1)
    if not (hard or formulation == "soft") or not solved.any():
        return None, None
    vehicle = asked.vehicle
    posed = pose_hard(vehicle) if hard else pose_soft(vehicle)
    taus = np.resize(asked.taus, (len(F), vehicle.k))[solved]
    B = taus @ posed.b_of_tau.T
    x = F[solved][:, posed.working] / posed.f_scale
    if not hard:  # s is what A f misses of b
        x = np.hstack([x, x @ posed.qp.A[:, : x.shape[1]].T - B])
    worth = certify_many(posed.qp, B, x)
    cost = np.einsum("ni,ij,nj->n", x, posed.qp.H, x) / 2
    return float((worth.gap / cost).max()), float(worth.distance.max() * posed.f_scale)


def _path(vehicle: Vehicle) -> FloatArray:
    # A path and not a random set: that is what a controller asks for and what a warm start is made
    # for. Thrusts swing sinusoidally, each at its own whole frequency and phase.
    phase = np.linspace(0.0, 2.0 * np.pi, N_DEMANDS, endpoint=False)[:, None]
    i = np.arange(vehicle.n)
    swing: FloatArray = (vehicle.f_max * np.sin((1 + i % 3) * phase + i)) @ vehicle.TP.T
    return swing


def _inactive(vehicle: Vehicle) -> FloatArray:
    # T* tau takes 60 % of the limits where it takes most.
    path = _path(vehicle)
    least: float = _closed_form_reach(vehicle, path).min()
    return 0.6 * least * path


def _active(vehicle: Vehicle) -> FloatArray:
    # Half way, in ratio, from where T* tau leaves the limits to where nothing meets the demand.
    path = _path(vehicle)
    closed, best = _closed_form_reach(vehicle, path), alpha_max(vehicle, path)
    room = best > 1.05 * closed
    if not room.any():
        raise NotApplicable(f"{vehicle.name}: no demand on the path needs more than T* tau")
    return np.resize(np.sqrt(closed * best)[room, None] * path[room], path.shape)


def _closed_form_reach(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """(N,) largest multiple of each demand that T* tau meets inside the limits."""
    F = taus @ generalized_inverse(vehicle).T
    on = vehicle.working
    reach: FloatArray = 1.0 / np.maximum(F[:, on] / vehicle.f_max[on], F[:, on] / vehicle.f_min[on]).max(
        axis=1
    )
    return reach
