"""Demands for the suite with their right answers, and the figures of merit of what a method answered."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocation, Allocator, Label, NotApplicable, Vehicle, alpha_max
from alloc.allocation import FloatArray
from alloc.discovery import Entry
from alloc.formulations import find_formulation
from alloc.formulations.hard import FORMULATION as HARD
from alloc.reach.attainable import closed_form_range
from bench.demands import labelled
from bench.judging.judge import judge, largest_gap
from bench.judging.question import Question, ask_here, questions

N_DEMANDS = 100

LABELS = ("inactive", "active")
"""T* tau meets inactive demands inside the limits; only a constrained method meets active demands there."""


MOVING = "moving"
"""The inactive demands, with limits that are new at each call: what new bounds cost."""

LEAST = 0.7
"""Share of the vehicle's limits that is always left of them; the path takes 60 %."""


@cache
def question(vehicle: Vehicle, label: str) -> Question:
    """A path of demands of one label, with the right answers of each formulation.

    Raises NotApplicable where the vehicle has no such demands.
    """
    if label == MOVING:
        left = LEAST + (1 - LEAST) * np.linspace(1.0, 0.0, N_DEMANDS)[:, None]
        return questions(
            [labelled(label, vehicle, _inactive(vehicle), left * vehicle.f_min, left * vehicle.f_max)],
            ask_here,
        )[0]
    demands = labelled(label, vehicle, {"inactive": _inactive, "active": _active}[label](vehicle))
    assert set(demands.labels) == {Label[label.upper()]}
    return questions([demands], ask_here)[0]


def of_one(benchmark: BenchmarkFixture, calls: int) -> None:
    """Have every table and file show the time of one call, where a round made ``calls`` of them."""
    if benchmark.stats is None:  # timing is switched off
        return
    stats = benchmark.stats
    stats.stats.data[:] = [seconds / calls for seconds in stats.stats.data]
    stats.iterations *= calls


def tell(
    benchmark: BenchmarkFixture,
    asked: Question,
    entry: Entry,
    allocator: Allocator,
    answers: Sequence[Allocation],
    **more: str | int,
) -> None:
    """Judge the answers that were timed, and put the figures into ``extra_info``.

    An answer that is not what its status says fails the test. An answer that lies further from the
    optimum than the method promises is an expected failure, with the distance as its reason.
    gap_rel_max is the duality gap over the cost, which needs no reference; None where no QP is answered.
    """
    judged = judge(
        asked,
        answers,
        formulation=allocator.formulation,
        limited=allocator.limited,
        tolerance=allocator.tolerance,
    )
    assert not judged.wrong
    gap = judged.gap_rel_max
    if asked.demands.name == "inactive" and not find_formulation(allocator.formulation).limited:
        # Inside the limits the answer of a closed form is the constrained optimum, so it has a gap too.
        F = np.array([answer.f for answer in answers])
        gap = largest_gap(asked, F, np.zeros(len(F), dtype=np.int8), HARD.name)
    benchmark.extra_info.update(
        vehicle=asked.demands.vehicle.name,
        label=asked.demands.name,
        method=entry.name,
        formulation=allocator.formulation,
        certificate={
            "counts": judged.counts,
            "wrench_error_rel_max": judged.wrench_error_rel_max,
            "limit_violation_max_N": judged.limit_violation_max_N,
            "distance_max_N": judged.distance_max_N,
            "gap_rel_max": gap,
        },
        **more,
    )
    if judged.agrees is False:
        pytest.xfail(f"{judged.distance_max_N:.3g} N from the optimum, more than its settings promise")


def _path(vehicle: Vehicle) -> FloatArray:
    # A controller asks for a path, and a warm start is made for one. Thrusts swing sinusoidally, each at
    # its own whole frequency and phase.
    phase = np.linspace(0.0, 2.0 * np.pi, N_DEMANDS, endpoint=False)[:, None]
    i = np.arange(vehicle.n)
    swing: FloatArray = (vehicle.f_max * np.sin((1 + i % 3) * phase + i)) @ vehicle.TP.T
    return swing


def _inactive(vehicle: Vehicle) -> FloatArray:
    # Scaled so that the largest thrust of T* tau on the path is 60 % of its limit.
    path = _path(vehicle)
    least: float = closed_form_range(vehicle, path)[1].min()
    if not least > 0:  # thrusters that push one way only would have to pull
        raise NotApplicable(f"{vehicle.name}: T* tau breaks a limit on the path, however small the demand")
    return 0.6 * least * path


def _active(vehicle: Vehicle) -> FloatArray:
    # Each demand is the geometric mean of where T* tau leaves the limits and where nothing meets it.
    path = _path(vehicle)
    closed, best = closed_form_range(vehicle, path)[1], alpha_max(vehicle, path)
    room = (closed > 0) & (best > 1.05 * closed)
    if not room.any():
        raise NotApplicable(f"{vehicle.name}: no demand on the path needs more than T* tau")
    return np.resize(np.sqrt(closed[room] * best[room])[:, None] * path[room], path.shape)
