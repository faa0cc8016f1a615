"""Answers that the gate calls wrong, by equations, and those of two sides that it calls different."""

from typing import Any, cast

import numpy as np
import pytest

from alloc import Allocation, Label, Status, Vehicle, build
from bench.gate.answers import SideAnswers, ask_side, find_difference, find_error
from bench.gate.record import GateCell
from bench.gate.side import Prober
from bench.gate.worker import packed
from bench.judging.question import Question
from tests.gate_sides import PROMISES, Here, at, changed

NOTHING = np.full(4, np.nan)


def test_the_exact_answers_are_right_and_do_not_differ(question: Question, right: list[Allocation]) -> None:
    side = SideAnswers("", PROMISES, right)
    assert find_error(question, side) == find_difference(question, side, side) == ""


def test_what_equations_say_of_an_answer_is_what_the_gate_says(
    vehicle: Vehicle, question: Question, right: list[Allocation]
) -> None:
    i, inactive = at(question, Label.ACTIVE), at(question, Label.INACTIVE)
    assert "the wrench is not met" in find_error(question, changed(right, i, 1.001 * right[i].f))
    assert "says INFEASIBLE" in find_error(question, changed(right, i, NOTHING, Status.INFEASIBLE))
    assert find_error(question, changed(right, at(question, Label.INFEASIBLE), np.zeros(4)))
    idle = np.linalg.svd(vehicle.T)[2][-1]  # pushes nothing, T idle = 0, and costs effort
    message = find_error(question, changed(right, inactive, right[inactive].f + idle))
    promised = PROMISES["tolerance"] * vehicle.f_scale
    assert message.endswith(f"N from the optimum, beyond its promise of {promised:.3g} N")
    at_odds = SideAnswers("", PROMISES, right, at_odds="many() differs")
    assert find_error(question, at_odds) == "many() differs"


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
        found += bool(find_error(whole, SideAnswers("", PROMISES, answers)))
    assert found >= 19


@pytest.mark.parametrize(("off", "says"), [(1.0, ""), (0.999, "shares of its levels")])
def test_a_share_that_thrusts_do_not_deliver_is_wrong(
    vehicle: Vehicle, question: Question, off: float, says: str
) -> None:
    side = cast("Prober", Here(vehicle, off))
    found = ask_side(side, GateCell(vehicle="ukwial", method="priority"), question)
    assert says in find_error(question, found)
    assert bool(says) == bool(find_error(question, found))


def test_thrusts_that_are_no_real_numbers_are_not_taken_for_their_real_parts() -> None:
    with pytest.raises(TypeError, match="complex"):
        packed(np.ones(3) * (1 + 1j))


@pytest.mark.parametrize(("share", "differs"), [(1.9, False), (2.1, True)])
def test_answers_may_differ_by_twice_what_the_base_promises_and_in_no_status(
    vehicle: Vehicle, question: Question, right: list[Allocation], share: float, differs: bool
) -> None:
    i, base = at(question, Label.ACTIVE), SideAnswers("", PROMISES, right)
    moved = right[i].f + share * PROMISES["tolerance"] * vehicle.f_scale  # type: ignore[operator]
    assert bool(find_difference(question, base, changed(right, i, moved))) == differs
    other = changed(right, i, right[i].f, Status.PARTIAL)
    assert find_difference(question, base, other) == f"status SOLVED → PARTIAL for demand {i}"


@pytest.mark.parametrize("formulation", ["mine", "hard"])
def test_an_answer_where_base_gave_up_is_no_regression(
    question: Question, right: list[Allocation], formulation: str
) -> None:
    promises = {**PROMISES, "formulation": formulation}
    i = at(question, Label.ACTIVE)
    gave_up = changed(right, i, NOTHING, Status.NOT_CONVERGED)
    base, head = (SideAnswers("", promises, answers) for answers in (gave_up.answers, right))
    assert find_difference(question, base, head) == ""
    assert f"SOLVED → NOT_CONVERGED for demand {i}" in find_difference(question, head, base)
    for f, status in ((NOTHING, Status.INFEASIBLE), (-0.5 * right[i].f, Status.PARTIAL)):
        other = changed(right, i, f, status).answers  # a fallback with the wrong sign
        assert find_difference(question, base, SideAnswers("", promises, other))


def test_a_wrong_answer_may_become_right_but_not_wrong_otherwise_nor_may_another_break(
    question: Question, right: list[Allocation]
) -> None:
    i, other = at(question, Label.ACTIVE), at(question, Label.INACTIVE)
    base = changed(right, i, 1.001 * right[i].f)
    assert find_difference(question, base, base) == ""
    assert find_difference(question, base, SideAnswers("", PROMISES, right)) == ""
    for head, says in (
        (changed(right, i, 1.01 * right[i].f), "thrusts differ by up to"),
        (changed(right, i, NOTHING, Status.SOLVED), "thrusts differ by up to inf N"),
        (changed(right, other, 1.001 * right[other].f), "thrusts differ"),
    ):
        assert says in find_difference(question, base, head)


@pytest.mark.parametrize(
    ("before", "now", "says"),
    [
        ({}, {"formulation": "soft"}, "formulation hard → soft: less is promised"),
        ({"formulation": "mine"}, {}, ""),
        ({}, {"tolerance": 0.9}, "tolerance 1e-06 → 0.9: less is promised"),
        ({"tolerance": 0.9}, {}, ""),
        ({}, {"limited": False}, "limited True → False: less is promised"),
        ({"limited": False}, {}, ""),
    ],
)
def test_a_head_that_promises_less_than_its_base_differs_and_one_that_promises_more_does_not(
    question: Question, right: list[Allocation], before: dict[str, Any], now: dict[str, Any], says: str
) -> None:
    base, head = (SideAnswers("", PROMISES | more, right) for more in (before, now))
    assert find_difference(question, base, head) == says


def test_a_head_without_the_shares_or_the_many_of_its_base_differs(
    question: Question, right: list[Allocation]
) -> None:
    """The first user would find out in the water."""
    whole = SideAnswers("", PROMISES, [answer._replace(share=(1.0,)) for answer in right])
    bare = SideAnswers("", PROMISES, right)
    assert find_difference(question, whole, bare) == "1 share → none for demand 0"
    assert find_difference(question, bare, whole) == ""
    assert find_difference(question, bare, bare._replace(many=False)) == "many() is gone"
