"""Which answers the gate calls wrong, and which different."""

from collections.abc import Callable
from math import inf
from typing import Any, cast

import numpy as np
import pytest

import alloc
from alloc import Allocation, Label, Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray, StatusArray
from alloc.nullspace.region import prepare
from bench.demands import DemandSet
from bench.gate.answers import SideAnswers, answered, differ, first, wrong
from bench.gate.examine import EDGES, FAILED, LOOKED_AT, MOVING, ONE_SIDE, demand_sets, judge_cell
from bench.gate.prober import Prober
from bench.gate.record import GateCell
from bench.gate.worker import Orders, packed
from bench.judging.question import Question, ask_here, questions

PROMISES = {"formulation": "hard", "limited": True, "tolerance": 1e-6}


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle("ukwial")


@pytest.fixture(scope="module")
def sets(vehicle: Vehicle) -> list[DemandSet]:
    return demand_sets(vehicle)


@pytest.fixture(scope="module")
def whole(sets: list[DemandSet]) -> Question:
    return questions(sets[:1], ask_here)[0]


@pytest.fixture(scope="module")
def question(whole: Question) -> Question:
    """The first hundred demands, all kinds mixed."""
    return first(whole, 100)


@pytest.fixture
def right(vehicle: Vehicle, question: Question) -> list[Allocation]:
    allocate = build("nullspace", vehicle)
    return [allocate(tau) for tau in question.demands.taus]


def at(question: Question, label: Label) -> int:
    """The first demand with that label."""
    return int(np.flatnonzero(question.demands.labels == label)[0])


def changed(answers: list[Allocation], i: int, f: FloatArray, status: Status = Status.SOLVED) -> SideAnswers:
    return SideAnswers("", PROMISES, [*answers[:i], Allocation(f, status), *answers[i + 1 :]])


def test_each_kind_is_asked_and_with_limits_of_its_own_and_with_each_thruster_off(
    vehicle: Vehicle, sets: list[DemandSet]
) -> None:
    mixed, moving, lower, upper, *failed = sets
    counts = np.bincount(mixed.labels, minlength=4)
    assert len(mixed.taus) == sum(LOOKED_AT.values()) + EDGES
    assert counts[Label.ACTIVE] >= LOOKED_AT["active"]
    assert counts[Label.BOUNDARY] >= LOOKED_AT["boundary"] + EDGES / 8
    assert (np.abs(mixed.alpha - 1.0) < 1e-12).sum() > EDGES / 8
    assert moving.f_min is not None
    assert len(moving.f_min) == MOVING["jolts"]
    assert (lower.f_max == vehicle.f_max).all()
    assert (upper.f_min == vehicle.f_min).all()
    assert len(lower.taus) == len(upper.taus) == ONE_SIDE
    assert [d.vehicle.faults for d in failed] == [((i, 0.0),) for i in range(vehicle.n)]
    assert all(len(d.taus) >= sum(FAILED.values()) - FAILED["active"] for d in failed)


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


class Here:
    """A side that answers in this process by ``priority``, with shares that are ``off`` by a factor."""

    def __init__(self, vehicle: Vehicle, off: float) -> None:
        allocate = build("priority", vehicle)

        def spoilt(tau: FloatArray) -> Allocation:
            answer = allocate(tau)
            return answer._replace(share=tuple(off * share for share in answer.share))

        self.orders = Orders()
        self.promises = {"formulation": "priority", "limited": True, "tolerance": 1e-9}
        self.orders.allocators["cell"] = spoilt

    def ask(self, order: str, **given: Any) -> Any:
        """Carry an order out."""
        if order == "build":
            return self.promises
        return self.orders.answers("cell", given["taus"], given["limits"], seconds=10.0)


@pytest.mark.parametrize(("off", "says"), [(1.0, ""), (0.999, "shares of its levels")])
def test_a_share_that_thrusts_do_not_deliver_is_wrong(
    vehicle: Vehicle, question: Question, off: float, says: str
) -> None:
    side = cast("Prober", Here(vehicle, off))
    found = answered(side, GateCell(vehicle="ukwial", method="priority"), question)
    assert says in wrong(question, found)
    assert bool(says) == bool(wrong(question, found))


class Whole:
    """A side that carries every order out in this process, with allocators that are ``spoilt``."""

    def __init__(self, spoilt: Callable[[Any], object]) -> None:
        self.orders, self.spoilt = Orders(), spoilt
        self.orders.alloc = alloc

    def ask(self, order: str, timeout: float = 0.0, **given: Any) -> Any:
        """Carry an order out, however long it takes."""
        reply = getattr(self.orders, order)(**given)
        if order == "build":
            self.spoilt(self.orders.allocators[given["cell"]])
        return reply


def astray(allocate: Any) -> None:
    """As ``scaled`` once was: a thin row has the last word, and nobody looks where thrusts end."""
    exact = allocate._exact
    exact._held = inf
    exact._blocks = [
        (rows, N, prepare(np.array(N), exact._slack, thin=1e-300)) for rows, N, _ in exact._blocks
    ]


@pytest.mark.parametrize(
    ("spoilt", "says"), [(astray, "nearly symmetric: shares of its levels"), (lambda _: None, "")]
)
def test_every_method_is_asked_a_nearly_symmetric_vehicle_too(
    question: Question, spoilt: Callable[[Any], object], says: str
) -> None:
    cell = GateCell(vehicle="ukwial", method="scaled")
    sides = cast("tuple[Prober, Prober]", (Whole(lambda _: None), Whole(spoilt)))
    few = [first(question, 20)]
    assert judge_cell(cell, sides, few, few) == ([], False)
    assert cell.turned_wrong.startswith(says)
    assert bool(cell.turned_wrong) == bool(says)
    assert cell.base_wrong == cell.differ == ""


def test_an_allocator_whose_many_is_at_odds_with_its_calls_is_wrong(
    question: Question, right: list[Allocation]
) -> None:
    assert wrong(question, SideAnswers("", PROMISES, right, "many() differs")) == "many() differs"


class Turned:
    """A rule that promises no distance; its many gives the thrusts of its calls times a factor."""

    formulation, limited, tolerance = "mine", True, 1.0

    def __init__(self, vehicle: Vehicle, factor: float) -> None:
        self.rule, self.factor = build("clip", vehicle), factor

    def __call__(self, tau: FloatArray) -> Allocation:
        """As the rule does."""
        return self.rule(tau)

    def many(self, taus: FloatArray) -> tuple[FloatArray, StatusArray]:
        """The rule's statuses, and other thrusts."""
        F, status = self.rule.many(taus)
        return self.factor * F, status


@pytest.mark.parametrize("factor", [-1.0, np.nan])
def test_who_promises_no_distance_still_answers_alike_in_many_and_in_calls(
    factor: float, vehicle: Vehicle, question: Question
) -> None:
    here = Here(vehicle, 1.0)
    here.orders.allocators["cell"] = Turned(vehicle, factor)
    here.promises = {"formulation": "mine", "limited": True, "tolerance": 1.0}
    found = answered(cast("Prober", here), GateCell(vehicle="ukwial", method="mine"), question)
    assert "from those of single calls" in wrong(question, found)


class BothOrNone:
    """An allocator that takes no notice of limits that come without the other side's."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.rule = build("nullspace", vehicle)

    def __call__(
        self, tau: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
    ) -> Allocation:
        """The optimum within both sides, else within the vehicle's limits."""
        return self.rule(tau) if f_min is None or f_max is None else self.rule(tau, f_min, f_max)


@pytest.mark.parametrize(("which", "says"), [(1, ""), (2, "f_min alone"), (3, "f_max alone")])
def test_limits_of_one_side_are_given_alone(
    which: int, says: str, vehicle: Vehicle, sets: list[DemandSet]
) -> None:
    asked = first(questions(sets[which : which + 1], ask_here)[0], 100)
    here = Here(vehicle, 1.0)
    here.orders.allocators["cell"] = BothOrNone(vehicle)
    here.orders.own["cell"] = vehicle.f_min, vehicle.f_max
    here.promises = PROMISES
    side, cell = cast("Prober", here), GateCell(vehicle="ukwial", method="mine")
    assert asked.demands.name == (says or "jolts")
    assert ("a limit is violated" in wrong(asked, answered(side, cell, asked))) == bool(says)


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


def test_answers_to_different_formulations_differ(question: Question, right: list[Allocation]) -> None:
    soft = SideAnswers("", {**PROMISES, "formulation": "soft"}, right)
    assert differ(question, SideAnswers("", PROMISES, right), soft) == "formulation hard → soft"


def test_a_head_that_promises_less_than_its_base_differs(question: Question, right: list[Allocation]) -> None:
    strict = SideAnswers("", PROMISES, right)
    loose = SideAnswers("", PROMISES | {"tolerance": 0.9}, right)
    assert "→ 0.9: less is promised" in differ(question, strict, loose)
    assert differ(question, loose, strict) == ""


def test_answers_differ_where_only_one_side_promises_limits(
    question: Question, right: list[Allocation]
) -> None:
    free = SideAnswers("", {**PROMISES, "limited": False}, right)
    assert differ(question, SideAnswers("", PROMISES, right), free) == "limited True → False"


def test_a_head_without_the_shares_or_the_many_of_its_base_differs(
    question: Question, right: list[Allocation]
) -> None:
    """Who calls them would find out in the water."""
    whole = SideAnswers("", PROMISES, [answer._replace(share=(1.0,)) for answer in right])
    bare = SideAnswers("", PROMISES, right)
    assert differ(question, whole, bare) == "1 share → none for demand 0"
    assert differ(question, bare, whole) == ""
    assert differ(question, bare, bare._replace(many=False)) == "many() is gone"


def test_thrusts_that_are_no_real_numbers_are_not_taken_for_their_real_parts() -> None:
    with pytest.raises(TypeError, match="complex"):
        packed(np.ones(3) * (1 + 1j))
