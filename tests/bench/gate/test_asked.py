"""Questions of the gate: demands, vehicles, limits and faults."""

from collections.abc import Callable
from math import inf
from typing import Any, cast

import numpy as np
import pytest

from alloc import Allocation, Label, NotApplicable, Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.nullspace.region import prepare
from alloc.vehicle.checks import ARRAYS
from bench.demands import DemandSet, build_demands
from bench.gate.answers import ask_side, find_error
from bench.gate.examine import side_vehicle
from bench.gate.questions import (
    AXES,
    EDGES,
    FAILED,
    FAILED_AXES,
    JOLTS,
    LOOKED_AT,
    MOVING,
    ONE_SIDE,
    nobody,
)
from bench.gate.record import GateCell
from bench.gate.side import Prober
from bench.judging.question import Question, ask_here, questions
from tests.gate_sides import PROMISES, Here, Whole, judged, same


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
    assert len(moving.f_min) == JOLTS
    assert (lower.f_max == vehicle.f_max).all()
    assert (upper.f_min == vehicle.f_min).all()
    assert len(lower.taus) == len(upper.taus) == ONE_SIDE
    assert [d.vehicle.faults for d in failed] == [((i, 0.0),) for i in range(vehicle.n)]
    assert all(len(d.taus) >= FAILED_AXES + sum(FAILED.values()) - FAILED["active"] for d in failed)


def astray(allocate: Any) -> Any:
    """As ``scaled`` once was: a thin row has the last word, and nobody looks where thrusts end."""
    exact = allocate._uncapped._exact
    exact._held = inf
    exact._blocks = [
        (rows, N, prepare(np.array(N), exact._slack, thin=1e-300)) for rows, N, _ in exact._blocks
    ]
    return allocate


@pytest.mark.parametrize(("spoilt", "says"), [(astray, "nearly symmetric: shares of its levels"), (same, "")])
def test_every_method_is_asked_a_nearly_symmetric_vehicle_too(
    question: Question, spoilt: Callable[[Any], Any], says: str
) -> None:
    cell, remarks = judged(same, spoilt, [question.rows(slice(20))])
    assert remarks == []
    assert cell.turned_wrong.startswith(says)
    assert bool(cell.turned_wrong) == bool(says)
    assert cell.base_wrong == cell.differ == ""


@pytest.mark.parametrize(
    ("own", "error", "excused"),
    [
        ("bluerov2-heavy", NotApplicable("made for mine"), True),
        ("ukwial", NotApplicable("made for mine"), True),
        ("ukwial", ValueError("too many values to unpack"), True),
        ("bluerov2-heavy", ValueError("no such DOF"), False),
    ],
)
def test_a_method_may_become_one_for_its_own_vehicle_alone(own: str, error: Exception, excused: bool) -> None:
    """Declared refusals excuse a method from the nearly symmetric vehicle; others need not know its size.

    A right plug-in that began to unpack its four axes was a regression of the user's own vehicle.
    """
    vehicle = load_vehicle(own)

    def for_its_own(allocate: Any) -> Any:
        if not (vehicle.T.shape == allocate._vehicle.T.shape and np.allclose(vehicle.T, allocate._vehicle.T)):
            raise error
        return allocate

    asked = questions([build_demands("inactive", vehicle, 1, 20)], nobody)
    cell, remarks = judged(same, for_its_own, asked, vehicle=own)
    said = f"{type(error).__name__}: {error}"
    assert cell.turned_wrong == cell.base_lacks == cell.differ == ""
    assert cell.head_lacks == ("" if excused else f"nearly symmetric: {said}")
    own_one = "no longer takes the gate's own vehicle, a nearly symmetric one"
    assert remarks == ([f"{own_one}: `{cell.name}`: {said}"] if excused else [])


@pytest.mark.parametrize("name", list_vehicles())
def test_a_vehicle_is_what_the_side_s_own_file_says(name: str) -> None:
    """Its levels and groups too: without them each of their answers was wrong on both sides."""
    side = Whole(same)
    seen, own = side_vehicle(cast("Prober", side), name), load_vehicle(name)
    assert (seen.dof, seen.priority, seen.groups) == (own.dof, own.priority, own.groups)
    for key in ARRAYS:
        np.testing.assert_array_equal(getattr(seen, key), getattr(own, key))
    for method in ("priority", "scaled-by-group"):
        (asked,) = questions([build_demands("infeasible", seen, 1, 40)], nobody)
        found = ask_side(cast("Prober", side), GateCell(vehicle=name, method=method), asked)
        assert find_error(asked, found) == ""


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
    asked = questions(sets[which : which + 1], ask_here)[0].rows(slice(100))
    here = Here(vehicle, 1.0)
    here.answers_by(BothOrNone(vehicle))
    here.promises = PROMISES
    side, cell = cast("Prober", here), GateCell(vehicle="ukwial", method="mine")
    assert asked.demands.name == (says or MOVING)
    assert ("a limit is violated" in find_error(asked, ask_side(side, cell, asked))) == bool(says)
