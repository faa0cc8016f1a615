"""Answers of two sides that the gate calls different."""

import numpy as np
import pytest

from alloc import Allocation, Label, Status, Vehicle
from bench.gate.answers import SideAnswers, differ
from bench.judging.question import Question
from tests.gate_sides import PROMISES, at, changed


def test_equal_answers_do_not_differ(question: Question, right: list[Allocation]) -> None:
    side = SideAnswers("", PROMISES, right)
    assert differ(question, side, side) == ""


@pytest.mark.parametrize(("share", "differs"), [(1.9, False), (2.1, True)])
def test_answers_may_differ_by_twice_what_the_base_promises(
    vehicle: Vehicle, question: Question, right: list[Allocation], share: float, differs: bool
) -> None:
    i = at(question, Label.ACTIVE)
    moved = right[i].f + share * PROMISES["tolerance"] * vehicle.f_scale  # type: ignore[operator]
    message = differ(question, SideAnswers("", PROMISES, right), changed(right, i, moved))
    assert bool(message) == differs


def test_answers_with_different_statuses_differ(question: Question, right: list[Allocation]) -> None:
    i = at(question, Label.ACTIVE)
    other = changed(right, i, right[i].f, Status.PARTIAL)
    differing = differ(question, SideAnswers("", PROMISES, right), other)
    assert differing == f"status SOLVED → PARTIAL for demand {i}"


@pytest.mark.parametrize("formulation", ["mine", "hard"])
def test_an_answer_where_base_gave_up_is_no_regression(
    question: Question, right: list[Allocation], formulation: str
) -> None:
    promises = {**PROMISES, "formulation": formulation}
    i, none = at(question, Label.ACTIVE), np.full(4, np.nan)
    gave_up = changed(right, i, none, Status.NOT_CONVERGED)
    base, head = (SideAnswers("", promises, answers) for answers in (gave_up.answers, right))
    assert differ(question, base, head) == ""
    assert f"SOLVED → NOT_CONVERGED for demand {i}" in differ(question, head, base)
    for f, status in ((none, Status.INFEASIBLE), (-0.5 * right[i].f, Status.PARTIAL)):
        other = changed(right, i, f, status).answers  # a fallback with the wrong sign
        assert differ(question, base, SideAnswers("", promises, other))


def test_a_wrong_answer_that_became_another_wrong_answer_differs(
    question: Question, right: list[Allocation]
) -> None:
    i = at(question, Label.ACTIVE)
    base = changed(right, i, 1.001 * right[i].f)
    assert differ(question, base, base) == ""
    assert "thrusts differ by up to" in differ(question, base, changed(right, i, 1.01 * right[i].f))
    nothing = changed(right, i, np.full(4, np.nan), Status.SOLVED)
    assert "thrusts differ by up to inf N" in differ(question, base, nothing)


def test_a_mended_answer_does_not_differ_and_another_that_broke_meanwhile_does(
    question: Question, right: list[Allocation]
) -> None:
    i, other = at(question, Label.ACTIVE), at(question, Label.INACTIVE)
    base, mended = changed(right, i, 1.001 * right[i].f), SideAnswers("", PROMISES, right)
    assert differ(question, base, mended) == ""
    broken = changed(right, other, 1.001 * right[other].f)
    assert "thrusts differ" in differ(question, base, broken)


def test_answers_to_another_formulation_differ_unless_it_promises_more(
    question: Question, right: list[Allocation]
) -> None:
    soft = SideAnswers("", {**PROMISES, "formulation": "soft"}, right)
    assert (
        differ(question, SideAnswers("", PROMISES, right), soft)
        == "formulation hard → soft: less is promised"
    )
    own = SideAnswers("", {**PROMISES, "formulation": "mine"}, right)
    assert differ(question, own, SideAnswers("", PROMISES, right)) == ""


def test_a_head_that_promises_less_than_its_base_differs(question: Question, right: list[Allocation]) -> None:
    strict = SideAnswers("", PROMISES, right)
    loose = SideAnswers("", PROMISES | {"tolerance": 0.9}, right)
    assert "→ 0.9: less is promised" in differ(question, strict, loose)
    assert differ(question, loose, strict) == ""


def test_answers_differ_where_limits_are_no_longer_promised(
    question: Question, right: list[Allocation]
) -> None:
    free = SideAnswers("", {**PROMISES, "limited": False}, right)
    promised = SideAnswers("", PROMISES, right)
    assert differ(question, promised, free) == "limited True → False: less is promised"
    assert differ(question, free, promised) == ""


def test_a_head_without_the_shares_or_the_many_of_its_base_differs(
    question: Question, right: list[Allocation]
) -> None:
    """The first user would find out in the water."""
    whole = SideAnswers("", PROMISES, [answer._replace(share=(1.0,)) for answer in right])
    bare = SideAnswers("", PROMISES, right)
    assert differ(question, whole, bare) == "1 share → none for demand 0"
    assert differ(question, bare, whole) == ""
    assert differ(question, bare, bare._replace(many=False)) == "many() is gone"
