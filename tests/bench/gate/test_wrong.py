"""Answers that the gate calls wrong."""

from typing import cast

import numpy as np
import pytest

from alloc import Allocation, Label, Status, Vehicle, build
from bench.gate.answers import SideAnswers, answered, wrong
from bench.gate.record import GateCell
from bench.gate.side import Prober
from bench.gate.worker import packed
from bench.judging.question import Question
from tests.gate_sides import PROMISES, Here, at, changed


def test_the_exact_answers_are_right(question: Question, right: list[Allocation]) -> None:
    assert wrong(question, SideAnswers("", PROMISES, right)) == ""


def test_an_answer_off_by_a_thousandth_is_wrong(question: Question, right: list[Allocation]) -> None:
    i = at(question, Label.ACTIVE)
    assert "the wrench is not met" in wrong(question, changed(right, i, 1.001 * right[i].f))


def test_thrusts_that_meet_the_wrench_with_more_effort_than_needed_are_wrong(
    vehicle: Vehicle, question: Question, right: list[Allocation]
) -> None:
    inactive = at(question, Label.INACTIVE)
    idle = np.linalg.svd(vehicle.T)[2][-1]  # pushes nothing: T idle = 0
    message = wrong(question, changed(right, inactive, right[inactive].f + idle))
    promised = PROMISES["tolerance"] * vehicle.f_scale
    assert message.endswith(f"N from the optimum, beyond its promise of {promised:.3g} N")


def test_the_status_infeasible_for_an_attainable_demand_is_wrong(
    question: Question, right: list[Allocation]
) -> None:
    i, nothing = at(question, Label.ACTIVE), np.full(4, np.nan)
    assert "says INFEASIBLE" in wrong(question, changed(right, i, nothing, Status.INFEASIBLE))


def test_the_status_solved_for_an_infeasible_demand_is_wrong(
    question: Question, right: list[Allocation]
) -> None:
    assert wrong(question, changed(right, at(question, Label.INFEASIBLE), np.zeros(4)))


@pytest.mark.parametrize("hit", ["all", "active"])
def test_what_is_wrong_in_one_demand_of_a_thousand_is_found(
    vehicle: Vehicle, whole: Question, hit: str
) -> None:
    """Each trial spoils an answer with probability 1/1000, of all demands or of the active ones."""
    F, status = build("nullspace", vehicle).many(whole.demands.taus)
    exact = [Allocation(f, Status(s)) for f, s in zip(F, status, strict=True)]
    spoilt = [Allocation(1.001 * f, Status.SOLVED) for f in F]
    candidates = np.isfinite(F).all(axis=1)
    if hit == "active":
        candidates &= whole.demands.labels == Label.ACTIVE
    found = 0
    for trial in range(20):
        chosen = candidates & (np.random.default_rng(trial).random(len(F)) < 1e-3)
        answers = [bad if c else good for c, good, bad in zip(chosen, exact, spoilt, strict=True)]
        found += bool(wrong(whole, SideAnswers("", PROMISES, answers)))
    assert found >= 19


@pytest.mark.parametrize(("off", "says"), [(1.0, ""), (0.999, "shares of its levels")])
def test_a_share_that_thrusts_do_not_deliver_is_wrong(
    vehicle: Vehicle, question: Question, off: float, says: str
) -> None:
    side = cast("Prober", Here(vehicle, off))
    found = answered(side, GateCell(vehicle="ukwial", method="priority"), question)
    assert says in wrong(question, found)
    assert bool(says) == bool(wrong(question, found))


def test_thrusts_that_are_no_real_numbers_are_not_taken_for_their_real_parts() -> None:
    with pytest.raises(TypeError, match="complex"):
        packed(np.ones(3) * (1 + 1j))
