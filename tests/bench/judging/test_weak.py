"""The judge holds each formulation to its own part of a demand, and counts losses of the strong part."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from alloc import Allocator, build, load_vehicle
from bench.demands import build_demands
from bench.demands.surveys import fail_thrusters, move_poses
from bench.judging.judge import judge
from bench.judging.question import Question, ask_here, questions
from bench.judging.weak import axis_costs, weak_lines
from bench.record import Judged

SURVEYED = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
HEAVY = move_poses(load_vehicle("bluerov2-heavy"), SURVEYED.survey, np.random.default_rng(3))
VEHICLES = {"surveyed": SURVEYED, "heavy": replace(fail_thrusters(HEAVY, (4, 5)), name="heavy")}
SETS = ("inactive", "active", "infeasible", "axes")


@cache
def asked(vehicle: str) -> list[Question]:
    return questions([build_demands(name, VEHICLES[vehicle], 0, 40) for name in SETS], ask_here)


def judged(question: Question, allocate: Allocator) -> Judged:
    given = [allocate(tau) for tau in question.demands.taus]
    promises = {key: getattr(allocate, key) for key in ("formulation", "limited", "tolerance")}
    return judge(question, given, **promises)


@pytest.mark.parametrize("vehicle", VEHICLES)
@pytest.mark.parametrize("method", ["scaled", "scaled-by-group", "priority", "nullspace", "clip", "pinv"])
def test_each_method_is_right_by_its_own_equations(vehicle: str, method: str) -> None:
    for question in asked(vehicle):
        found = judged(question, build(method, VEHICLES[vehicle]))
        assert found.objection == ""


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_methods_with_a_share_lose_nothing_that_can_be_met_and_others_much(vehicle: str) -> None:
    inactive = asked(vehicle)[0]
    by_method = {
        name: judged(inactive, build(name, VEHICLES[vehicle])) for name in ("scaled", "nullspace", "clip")
    }
    scaled = by_method["scaled"]
    assert scaled.missed_max == pytest.approx(0.0, abs=1e-9)
    assert scaled.counts.get("SOLVED", 0) + scaled.partial_by_weak == 40
    assert scaled.loss["effort_over_optimum_max"] == pytest.approx(0.0, abs=1e-9)
    assert by_method["nullspace"].missed_max == 1.0
    assert by_method["nullspace"].counts["INFEASIBLE"] > 10
    clip = by_method["clip"].missed_max
    assert clip is not None
    assert clip > 0.1


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_a_share_that_holds_the_weak_axis_is_found_wrong(vehicle: str) -> None:
    held = build("scaled", replace(VEHICLES[vehicle], weak_limit=0.0))
    found = judged(asked(vehicle)[0], held)
    assert "shares of its levels that its thrusts do not deliver" in found.wrong


def test_surge_costs_nothing_with_a_share_all_of_it_with_clip_and_is_refused_by_nullspace() -> None:
    costs = {cost.axis: cost for cost in axis_costs(SURVEYED)}
    assert list(costs) == ["surge", "sway", "heave", "roll", "yaw"]
    surge = costs["surge"]
    assert surge.hard_most == pytest.approx(11.96, abs=0.01)
    assert surge.wrench["scaled"] == pytest.approx(surge.demand, rel=0.04)
    assert surge.wrench["nullspace"] is None
    assert surge.wrench["clip"] == pytest.approx(0.0, abs=1.0)
    assert surge.words("nullspace", "N") == "refused; at most 12 N, thrusts up to 40 N"
    heave = costs["heave"]
    assert heave.wrench["nullspace"] == pytest.approx(heave.demand)
    assert heave.thrust_N["nullspace"] > heave.thrust_N["scaled"] * 1.1  # four others push for nothing
    assert any("pitch (0.5 % left)" in line for line in weak_lines(SURVEYED))
    assert axis_costs(load_vehicle("bluerov2")) == weak_lines(load_vehicle("bluerov2")) == []
