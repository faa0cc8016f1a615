"""Which answers the gate calls wrong, and which different."""

from collections.abc import Callable
from math import inf
from typing import Any, cast

import numpy as np
import pytest

import alloc
from alloc import Allocation, Label, Status, Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray, StatusArray
from alloc.nullspace.region import prepare
from alloc.vehicle.checks import ARRAYS
from bench.demands import DemandSet, build_demands
from bench.gate import forms
from bench.gate.answers import SideAnswers, answered, differ, first, wrong
from bench.gate.asked import (
    AXES,
    EDGES,
    FAILED,
    FAILED_AXES,
    LOOKED_AT,
    MOVING,
    ONE_SIDE,
    demand_sets,
    nobody,
)
from bench.gate.examine import judge_cell, vehicle_of
from bench.gate.given import farthest, packed
from bench.gate.prober import Prober
from bench.gate.record import GateCell
from bench.gate.side import Refused
from bench.gate.worker import Orders
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
    """The first demands: none, those on one axis and on two, and a hundred more of all kinds."""
    return first(whole, AXES + 113)


@pytest.fixture
def right(vehicle: Vehicle, question: Question) -> list[Allocation]:
    allocate = build("nullspace", vehicle)
    return [allocate(tau) for tau in question.demands.taus]


def at(question: Question, label: Label) -> int:
    """The first demand with that label that asks for something."""
    asked = question.demands.taus.any(axis=1)
    return int(np.flatnonzero(asked & (question.demands.labels == label))[0])


def changed(answers: list[Allocation], i: int, f: FloatArray, status: Status = Status.SOLVED) -> SideAnswers:
    return SideAnswers("", PROMISES, [*answers[:i], Allocation(f, status), *answers[i + 1 :]])


def test_each_kind_is_asked_and_with_limits_of_its_own_and_with_each_thruster_off(
    vehicle: Vehicle, sets: list[DemandSet]
) -> None:
    mixed, moving, lower, upper, *failed = sets
    counts = np.bincount(mixed.labels, minlength=4)
    pairs = 4 * vehicle.k * (vehicle.k - 1) // 2
    assert len(mixed.taus) == 1 + AXES + pairs + sum(LOOKED_AT.values()) + EDGES
    assert set(np.count_nonzero(mixed.taus[AXES + 1 :][:pairs], axis=1)) == {2}
    *failed, two, others, last, weaker, resized, wider = failed
    assert [len(d.vehicle.faults) for d in (two, others, last, weaker)] == [2, 2, 2, 1]
    assert 0 < weaker.vehicle.readiness[0] < 1
    assert resized.alpha.min() < 0.01
    assert resized.alpha.max() > 100
    assert (wider.limits[1] == 2 * vehicle.f_max).all()
    failed, both = failed[: vehicle.n], failed[vehicle.n :]
    assert [d.vehicle.faults for d in both] == [d.vehicle.faults for d in failed]
    assert all((d.f_max > 0).all() for d in both if d.f_max is not None)  # of the one that is off too
    for asked, n in ((mixed, AXES), *((off, FAILED_AXES) for off in failed)):
        entries = np.count_nonzero(asked.taus[: n + 1], axis=1)
        assert entries[0] == 0
        assert set(entries[1:]) == {1}
        assert (np.abs(asked.taus[1 : n + 1]).max(axis=0) > 0).all()
    assert counts[Label.ACTIVE] >= LOOKED_AT["active"]
    assert counts[Label.BOUNDARY] >= LOOKED_AT["boundary"] + EDGES / 8
    assert (np.abs(mixed.alpha - 1.0) < 1e-12).sum() > EDGES / 8
    assert moving.f_min is not None
    assert len(moving.f_min) == MOVING["jolts"]
    assert (lower.f_max == vehicle.f_max).all()
    assert (upper.f_min == vehicle.f_min).all()
    assert len(lower.taus) == len(upper.taus) == ONE_SIDE
    assert [d.vehicle.faults for d in failed] == [((i, 0.0),) for i in range(vehicle.n)]
    assert all(len(d.taus) >= FAILED_AXES + sum(FAILED.values()) - FAILED["active"] for d in failed)


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
        self.orders.alloc = alloc
        self.orders.allocators["cell"] = spoilt
        self.orders.own["cell"] = vehicle.f_min, vehicle.f_max

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

    def __init__(self, spoilt: Callable[[Any], Any]) -> None:
        self.orders, self.spoilt = Orders(), spoilt
        self.orders.alloc = alloc

    def ask(self, order: str, timeout: float = 0.0, **given: Any) -> Any:
        """Carry an order out, however long it takes."""
        try:
            reply = getattr(self.orders, order)(**given)
        except Exception as error:
            raise Refused(f"{type(error).__name__}: {error}", type(error).__name__) from error
        if order == "build":
            cell = given["cell"]
            made = self.spoilt(self.orders.allocators[cell])
            self.orders.allocators[cell] = made
            if not given.get("weaker") and "numbers" not in given:
                self.orders.early[cell] = self.orders.early[cell]._replace(allocate=made)
        return reply


def astray(allocate: Any) -> Any:
    """As ``scaled`` once was: a thin row has the last word, and nobody looks where thrusts end."""
    exact = allocate._exact
    exact._held = inf
    exact._blocks = [
        (rows, N, prepare(np.array(N), exact._slack, thin=1e-300)) for rows, N, _ in exact._blocks
    ]
    return allocate


@pytest.mark.parametrize(
    ("spoilt", "says"), [(astray, "nearly symmetric: shares of its levels"), (lambda same: same, "")]
)
def test_every_method_is_asked_a_nearly_symmetric_vehicle_too(
    question: Question, spoilt: Callable[[Any], Any], says: str
) -> None:
    cell = GateCell(vehicle="ukwial", method="scaled")
    sides = cast("tuple[Prober, Prober]", (Whole(lambda same: same), Whole(spoilt)))
    few = [first(question, 20)]
    assert judge_cell(cell, sides, few, few) == ([], False)
    assert cell.turned_wrong.startswith(says)
    assert bool(cell.turned_wrong) == bool(says)
    assert cell.base_wrong == cell.differ == ""


def test_an_allocator_whose_many_is_at_odds_with_its_calls_is_wrong(
    question: Question, right: list[Allocation]
) -> None:
    assert wrong(question, SideAnswers("", PROMISES, right, at_odds="many() differs")) == "many() differs"


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


@pytest.mark.parametrize("name", list_vehicles())
def test_a_vehicle_is_what_the_side_s_own_file_says(name: str) -> None:
    """Its levels and groups too: without them each of their answers was wrong on both sides."""
    side = Whole(lambda allocate: allocate)
    seen, own = vehicle_of(cast("Prober", side), name), load_vehicle(name)
    assert (seen.dof, seen.priority, seen.groups) == (own.dof, own.priority, own.groups)
    for key in ARRAYS:
        np.testing.assert_array_equal(getattr(seen, key), getattr(own, key))
    for method in ("priority", "scaled-by-group"):
        asked = first(questions([build_demands("infeasible", seen, 1, 40)], nobody)[0], 40)
        found = answered(cast("Prober", side), GateCell(vehicle=name, method=method), asked)
        assert wrong(asked, found) == ""


def of_scaled(change: str, more: str = "") -> Callable[[Any], Any]:
    """A function that wraps ``scaled`` in a class whose answers that line changes, as users write one.

    ``more`` are lines behind it, for methods of the class.
    """
    scope: dict[str, Any] = {"np": np}
    exec(  # the lines are statements
        "class Mine:\n"
        "    formulation, limited, tolerance = 'mine', True, 1.0\n"
        "    built = []\n"
        "    def __init__(self, inner):\n"
        "        vehicle = inner._vehicle\n"
        "        self.inner, self.buffer, self.off = inner, np.zeros(vehicle.n), vehicle.readiness == 0\n"
        "        self.low, self.high = vehicle.f_min, vehicle.f_max\n"
        "        self.weak = (vehicle.readiness > 0) & (vehicle.readiness < 1)\n"
        "        self.built.append(self)\n"
        "    def __call__(self, tau, f_min=None, f_max=None):\n"
        "        f, status, iterations, seconds, share = self.inner(tau, f_min, f_max)\n"
        f"        {change}\n"
        f"        return f, status, iterations, seconds, share\n{more}",
        scope,
    )
    made: Callable[[Any], Any] = scope["Mine"]
    return made


SPOILT = {
    "tau[:] = 0": "it writes into the demand, or the limits, that it is given",
    "f = f.tolist()": "not an array of n thrusts",
    "f = f[:, None]": "not an array of n thrusts",
    "self.buffer[:] = f; f = self.buffer": "",
    "f = -f if np.count_nonzero(tau) == 1 else f": "",
    "f = f + 9 if not tau.any() else f": "",
    "f = -f if np.count_nonzero(tau) == 2 else f": "",
    "f = np.where(self.off & (f_min is not None), 5.0, f)": "a thrust on a thruster that is off",
    "share = (7.0,)": "shares of its levels",
    "share = (share[0] / 2,)": "shares 1 → 0.5 for demand 0",
    "if tau[1] > 100: raise ValueError('no such sway')": "raises ValueError: no such sway, for demand ",
    "if self.off[2] and tau[0] > 0: raise ValueError('hm')": "thruster 2 off: raises ValueError: hm",
    "f = f + 1.0 * self.off": "a thrust on a thruster that is off",
    "f = f * (len(self.built) < 3)": "",
    "f = f if self.off.sum() < 2 else -f": "thrusters 0 and 1 off",
    "f = np.where(self.weak, 1.0, f)": "thruster 0 weaker",
    "f = f if np.abs(tau).max() < 1e4 else 0 * f": "near rest or far out",
}
"""How an answer may be spoilt, and what the gate says; empty where several words are right."""


@pytest.mark.parametrize("change", SPOILT)
def test_what_a_class_of_one_s_own_may_get_wrong_is_found(
    vehicle: Vehicle, change: str, sets: list[DemandSet]
) -> None:
    cell = GateCell(vehicle="ukwial", method="scaled")
    sides = cast("tuple[Prober, Prober]", (Whole(of_scaled("")), Whole(of_scaled(change))))
    asked = questions([sets[i] for i in (0, 1, -12, -8, -6, -3, -2)], nobody)
    asked = [first(question, 80) for question in asked]
    judge_cell(cell, sides, asked, asked)
    assert cell.turned_wrong or cell.differ
    assert SPOILT[change] in f"{cell.turned_wrong} {cell.differ}"
    assert cell.base_wrong == cell.base_lacks == cell.head_lacks == ""


def test_a_call_that_raises_on_both_sides_costs_that_demand_alone(
    vehicle: Vehicle, sets: list[DemandSet]
) -> None:
    """Where one demand raised, the sign of all others went unseen."""
    raising = "if tau[1] > 100: raise ValueError('no such sway')"
    cell = GateCell(vehicle="ukwial", method="scaled")
    spoilt = (Whole(of_scaled(raising)), Whole(of_scaled(f"f = -f\n        {raising}")))
    asked = [first(questions(sets[:1], nobody)[0], 80)]
    judge_cell(cell, cast("tuple[Prober, Prober]", spoilt), asked, asked)
    assert cell.base_wrong.startswith("raises ValueError: no such sway, for demand ")
    assert "thrusts differ by up to" in cell.differ


def test_what_neither_side_answers_is_said_with_the_reason(vehicle: Vehicle, sets: list[DemandSet]) -> None:
    raising = "if self.off.any(): raise ValueError('no faults yet')"
    cell = GateCell(vehicle="ukwial", method="scaled")
    sides = cast("tuple[Prober, Prober]", (Whole(of_scaled(raising)), Whole(of_scaled(raising))))
    asked = [first(q, 20) for q in questions([sets[i] for i in (0, 7)], nobody)]
    remarks, _ = judge_cell(cell, sides, asked, asked)
    assert remarks == [
        "no answers with thruster 3 off were compared: `ukwial:scaled:-` fails on both sides:"
        " ValueError: no faults yet"
    ]


@pytest.mark.parametrize(("factor", "says"), [(1.0, ""), (3.0, "a limit is violated")])
def test_limits_of_each_call_that_are_new_are_judged(
    vehicle: Vehicle, factor: float, says: str, sets: list[DemandSet]
) -> None:
    """Head's alone were passed unseen, and said three times."""
    refusing = "if f_min is not None or f_max is not None: raise alloc.NotApplicable('no limits')"
    head = f"f = f if f_min is None or f_max is None else {factor} * f"
    cell = GateCell(vehicle="ukwial", method="scaled")
    base = of_scaled(f"import alloc\n        {refusing}")
    sides = cast("tuple[Prober, Prober]", (Whole(base), Whole(of_scaled(head))))
    asked = [first(q, 60) for q in questions(sets[:4], nobody)]
    remarks, _ = judge_cell(cell, sides, asked, asked)
    assert remarks == ["limits of each call are new: `ukwial:scaled:-`"]
    assert says in cell.turned_wrong
    assert bool(says) == bool(cell.turned_wrong)


@pytest.mark.parametrize("length", [1, 10])
def test_many_is_asked_short_batches_too(vehicle: Vehicle, question: Question, length: int) -> None:
    class Short(Turned):
        def many(self, taus: FloatArray) -> tuple[FloatArray, StatusArray]:
            F, status = self.rule.many(taus)
            return (-F if len(F) == length else F), status

    here = Here(vehicle, 1.0)
    here.orders.allocators["cell"] = Short(vehicle, 1.0)
    here.promises = {"formulation": "mine", "limited": True, "tolerance": 1.0}
    few = first(question, 60)
    found = answered(cast("Prober", here), GateCell(vehicle="ukwial", method="mine"), few)
    assert f"many() of {length} demand" in wrong(few, found)


FORMS = {
    "a list of whole numbers": "tau = np.asarray(tau)\n        if tau.dtype.kind in 'iu': f = np.trunc(f)",
    "an array of whole numbers": "f = np.trunc(f) if getattr(tau, 'dtype', f.dtype).kind == 'i' else f",
    "an array made of columns": "f = f if np.asarray(tau).flags.c_contiguous else -f",
    "an array in single precision": "f = -f if getattr(tau, 'dtype', None) == np.float32 else f",
    "limits in lists": "f_min is None or f_min.shape",
    "limits in an array made of columns": (
        "f = f if f_min is None or np.asarray(f_min).flags.c_contiguous else -f"
    ),
    "limits wider than the vehicle's": "f = np.clip(f, self.low, self.high)",
    "an array that is used again": (
        "f = self.f if getattr(self, 'tau', None) is tau else f\n        self.tau, self.f = tau, f.copy()"
    ),
    "a demand next to the last": (
        "near = hasattr(self, 'tau') and np.abs(self.tau - tau).max() < 1e-3 * np.abs(tau).max()\n"
        "        f = self.f if near else f\n"
        "        self.tau, self.f = np.array(tau), f.copy()"
    ),
    "limits behind a call without": (
        "alike = hasattr(self, 'tau') and np.array_equal(self.tau, tau)\n"
        "        f = self.f if alike and f_min is not None else f\n"
        "        self.tau, self.f = np.array(tau), f.copy()"
    ),
    "no limits behind a call with": (
        "f = np.clip(f, *self.ends) if f_min is None and hasattr(self, 'ends') else f\n"
        "        if f_min is not None: self.ends = f_min, f_max"
    ),
}
MANY = {
    "many() with one row of limits": "if np.ndim(f_min) == 1: f_min = f_max = None",
    "many() of a list of whole numbers": "taus.shape",
    "many() of an array of whole numbers": "taus = -taus if getattr(taus, 'dtype', '') == int else taus",
    "many() of an array made of columns": "if not np.asarray(taus).flags.c_contiguous: taus = -taus",
    "many() of an array in single precision": "if np.asarray(taus).dtype == np.float32: taus = -taus",
    "many() with limits in an array made of columns": (
        "if f_min is not None and not f_min.flags.c_contiguous: f_min = f_max = None"
    ),
}
BY_NAME = "    def __call__(self, tau, low=None, high=None):\n        return self.inner(tau, low, high)\n"
WRITES = """\
    def many(self, taus, f_min=None, f_max=None):
        answered = self.inner.many(taus, f_min, f_max)
        if f_min is not None: f_min *= 1.5
        return answered
"""
BUFFER = """\
    def many(self, taus, f_min=None, f_max=None):
        F, status = self.inner.many(taus, f_min, f_max)
        self.kept = self.kept if hasattr(self, 'kept') else np.zeros((10_000, F.shape[1]))
        self.kept[: len(F)] = F
        return self.kept[: len(F)], status
"""


def with_many(line: str = "pass") -> str:
    """A function of a class that answers many demands, with a line that may spoil that."""
    return (
        "    def many(self, taus, f_min=None, f_max=None):\n"
        f"        {line}\n"
        "        return self.inner.many(taus, f_min, f_max)\n"
    )


MORE = {
    **{form: with_many(line) for form, line in MANY.items()},
    "limits by name": BY_NAME + with_many(),
    "many() called again": BUFFER,
    "what many() is given": WRITES,
}
"""How a form of calls may be spoilt: by a line of the usual call, or by methods of the class."""


@pytest.mark.parametrize("form", [*FORMS, *MORE])
def test_other_forms_of_calls_are_asked_and_held_to_the_usual_one(
    vehicle: Vehicle, sets: list[DemandSet], form: str
) -> None:
    cell = GateCell(vehicle="ukwial", method="scaled")
    base, head = of_scaled("", with_many()), of_scaled(FORMS.get(form, ""), MORE.get(form, with_many()))
    sides = cast("tuple[Prober, Prober]", (Whole(base), Whole(head)))
    asked = [first(question, 60) for question in questions([sets[i] for i in (0, 1, -1)], nobody)]
    judge_cell(cell, sides, asked, asked)
    assert cell.turned_wrong.startswith(f"{form}: ")
    assert cell.base_wrong == ""
    cell = GateCell(vehicle="ukwial", method="scaled")
    judge_cell(cell, (sides[1], sides[0]), asked, asked)  # the other way round it is mended
    assert cell.turned_wrong == ""
    assert cell.base_wrong.startswith(f"{form}: ")


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
    """Who calls them would find out in the water."""
    whole = SideAnswers("", PROMISES, [answer._replace(share=(1.0,)) for answer in right])
    bare = SideAnswers("", PROMISES, right)
    assert differ(question, whole, bare) == "1 share → none for demand 0"
    assert differ(question, bare, whole) == ""
    assert differ(question, bare, bare._replace(many=False)) == "many() is gone"


def test_thrusts_that_are_no_real_numbers_are_not_taken_for_their_real_parts() -> None:
    with pytest.raises(TypeError, match="complex"):
        packed(np.ones(3) * (1 + 1j))


def test_a_method_whose_calls_take_long_is_asked_fewer_demands_in_other_forms(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its process would be ended for it, and the head alone called wrong."""
    asked, taus = list[FloatArray](), np.ones((20, vehicle.k))

    def call(tau: FloatArray) -> Allocation:
        asked.append(tau)
        return Allocation(np.zeros(vehicle.n), Status.PARTIAL)

    monkeypatch.setattr(forms, "LONGEST_S", 0.0)
    assert forms.forms(call, taus, taus, taus, farthest) == {}
    assert len(asked) == forms.PROBED
