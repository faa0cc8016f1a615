"""Which answers the gate calls wrong, and which different."""

import numpy as np
import pytest

from alloc import Allocation, Label, Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from bench.gate.answers import DEMANDS, SideAnswers, ask_question, differ, wrong
from bench.judging.question import Question, ask_here

PROMISES = {"formulation": "hard", "limited": True, "tolerance": 1e-6}


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle("ukwial")


@pytest.fixture(scope="module")
def question(vehicle: Vehicle) -> Question:
    return ask_question(vehicle, ask_here)


@pytest.fixture
def right(vehicle: Vehicle, question: Question) -> list[Allocation]:
    allocate = build("nullspace", vehicle)
    return [allocate(tau) for tau in question.demands.taus]


def changed(answers: list[Allocation], i: int, f: FloatArray, status: Status = Status.SOLVED) -> SideAnswers:
    return SideAnswers("", PROMISES, [*answers[:i], Allocation(f, status), *answers[i + 1 :]])


def test_demands_of_each_kind_are_asked(question: Question) -> None:
    assert [int(n) for n in np.bincount(question.demands.labels, minlength=4)] == [
        DEMANDS["inactive"],
        DEMANDS["active"],
        0,
        DEMANDS["infeasible"],
    ]


def test_the_exact_answers_are_right(question: Question, right: list[Allocation]) -> None:
    assert wrong(question, SideAnswers("", PROMISES, right)) == ""


def test_an_answer_off_by_a_thousandth_is_wrong(question: Question, right: list[Allocation]) -> None:
    assert "the wrench is not met" in wrong(question, changed(right, 3, 1.001 * right[3].f))


def test_thrusts_that_meet_the_wrench_with_more_effort_than_needed_are_wrong(
    vehicle: Vehicle, question: Question, right: list[Allocation]
) -> None:
    inactive = int(np.flatnonzero(question.demands.labels == Label.INACTIVE)[0])
    idle = np.linalg.svd(vehicle.T)[2][-1]  # pushes nothing: T idle = 0
    message = wrong(question, changed(right, inactive, right[inactive].f + idle))
    assert "from the optimum, beyond its promise" in message


def test_the_status_infeasible_for_an_attainable_demand_is_wrong(
    question: Question, right: list[Allocation]
) -> None:
    nothing = np.full(4, np.nan)
    assert "says INFEASIBLE" in wrong(question, changed(right, 0, nothing, Status.INFEASIBLE))


def test_the_status_solved_for_an_infeasible_demand_is_wrong(
    question: Question, right: list[Allocation]
) -> None:
    last = len(right) - 1
    assert question.demands.labels[last] == Label.INFEASIBLE
    assert wrong(question, changed(right, last, np.zeros(4)))


def test_equal_answers_do_not_differ(vehicle: Vehicle, right: list[Allocation]) -> None:
    side = SideAnswers("", PROMISES, right)
    assert differ(vehicle, side, side) == ""


@pytest.mark.parametrize(("share", "differs"), [(1.9, False), (2.1, True)])
def test_answers_may_differ_by_twice_what_the_base_promises(
    vehicle: Vehicle, right: list[Allocation], share: float, differs: bool
) -> None:
    moved = right[0].f + share * PROMISES["tolerance"] * vehicle.f_scale  # type: ignore[operator]
    message = differ(vehicle, SideAnswers("", PROMISES, right), changed(right, 0, moved))
    assert bool(message) == differs


def test_answers_with_different_statuses_differ(vehicle: Vehicle, right: list[Allocation]) -> None:
    other = changed(right, 2, right[2].f, Status.PARTIAL)
    assert differ(vehicle, SideAnswers("", PROMISES, right), other) == "status SOLVED → PARTIAL for demand 2"


def test_answers_to_different_formulations_differ(vehicle: Vehicle, right: list[Allocation]) -> None:
    soft = SideAnswers("", {**PROMISES, "formulation": "soft"}, right)
    assert differ(vehicle, SideAnswers("", PROMISES, right), soft) == "formulation hard → soft"


def test_answers_differ_where_only_one_side_promises_limits(
    vehicle: Vehicle, right: list[Allocation]
) -> None:
    free = SideAnswers("", {**PROMISES, "limited": False}, right)
    assert differ(vehicle, SideAnswers("", PROMISES, right), free) == "limited True → False"
