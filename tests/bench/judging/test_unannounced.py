"""Failures that nobody announces: what is made of the thrusts told, and what that costs."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from alloc import Vehicle, alpha_max, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.reach.volumes import uniform_demands
from bench.judging.capability import measure_capabilities
from bench.judging.question import ask_here
from bench.judging.unannounced import (
    DEMANDS,
    FAILURES,
    announced_costs,
    announced_thrusts,
    failed_thrusts,
    failure_costs,
)

N = 200


@cache
def asked(name: str) -> tuple[Vehicle, FloatArray, FloatArray]:
    """A vehicle, demands that it can meet, and the thrusts that meet them."""
    vehicle = load_vehicle(name)
    taus = uniform_demands(vehicle, np.random.default_rng(5), N)
    return vehicle, taus, build("scaled", vehicle).many(taus)[0]


@pytest.mark.parametrize("failure", FAILURES)
@pytest.mark.parametrize("name", ["ukwial", "bluerov2-heavy", "double-ended-ferry"])
def test_the_wrench_misses_what_the_failed_thruster_does_not_make_and_nothing_else(
    name: str, failure: str
) -> None:
    vehicle, taus, F = asked(name)
    for i, own in enumerate(map(list, vehicle.actuators)):
        made = failed_thrusts(vehicle, F, i, failure)
        missing = (F[:, own] - made[:, own]) @ vehicle.T[:, own].T
        assert made @ vehicle.T.T == pytest.approx(taus - missing, abs=1e-6 * vehicle.f_scale)


def test_a_stuck_thruster_makes_what_the_demand_before_had_of_it() -> None:
    vehicle, _, F = asked("ukwial")
    made = failed_thrusts(vehicle, F, 2, "stuck")
    assert made[1:, 2] == pytest.approx(F[:-1, 2])
    assert made[:, [0, 1, 3]] == pytest.approx(F[:, [0, 1, 3]])


def test_thrusts_are_cut_at_the_limits_before_the_thruster_fails() -> None:
    vehicle = load_vehicle("bluerov2-heavy")  # 51 N ahead, 40 N astern
    told = np.full((1, vehicle.n), 1000.0)
    assert failed_thrusts(vehicle, told, 0, "reversed")[0, 0] == -vehicle.f_max[0]
    assert failed_thrusts(vehicle, told, 0, "half")[0, 0] == vehicle.f_max[0] / 2
    assert told[0, 0] == 1000.0


@pytest.mark.parametrize("name", list_vehicles())
def test_a_reversed_thruster_turns_the_wrench_more_than_one_that_is_off_and_half_turns_least(
    name: str,
) -> None:
    vehicle, taus, F = asked(name)
    costs = {cost.failure: cost for cost in failure_costs(vehicle, "scaled", taus, F)}
    for half, off, turned in zip(
        *(costs[each].turned_p50_deg for each in ("half", "off", "reversed")), strict=True
    ):
        assert half < off < turned  # type: ignore[operator]  # None where nothing is delivered
    # Share along the demand is linear in the thrust that is missing: off loses twice what half does.
    for half, off, turned in zip(
        *(costs[each].share_p50 for each in ("half", "off", "reversed")), strict=True
    ):
        assert 1 - off == pytest.approx(2 * (1 - half), rel=1e-3)
        assert 1 - turned == pytest.approx(4 * (1 - half), rel=1e-3)


@pytest.mark.parametrize("failure", FAILURES)
def test_once_announced_thrusts_are_within_what_the_failure_leaves(failure: str) -> None:
    vehicle, taus, F = asked("bluerov2-heavy")
    for i in (0, 5):
        made = announced_thrusts(vehicle, taus, F, i, failure)
        low, high = vehicle.f_min.copy(), vehicle.f_max.copy()
        low[i], high[i] = {
            "off": (0.0, 0.0),
            "stuck": (F[:, i].min(), F[:, i].max()),
            "half": (low[i] / 2, high[i] / 2),
            "reversed": (-high[i], -low[i]),
        }[failure]
        assert (made >= low - 1e-9).all()
        assert (made <= high + 1e-9).all()


@pytest.mark.parametrize("failure", FAILURES)
def test_once_announced_a_thruster_that_turns_stays_within_what_its_failure_leaves(failure: str) -> None:
    vehicle, taus, F = asked("double-ended-ferry")
    made = announced_thrusts(vehicle, taus, F, 1, failure)
    (x, y), most = vehicle.actuators[1], {"off": 0.0, "half": 250.0}.get(failure, 500.0)
    assert np.hypot(made[:, x], made[:, y]) == pytest.approx(np.zeros(N), abs=most + 1e-6)
    if failure == "stuck":
        assert made[1:, [x, y]] == pytest.approx(F[:-1, [x, y]])
    if failure == "reversed":  # half a turn of a disc is the same disc
        assert made @ vehicle.T.T == pytest.approx(taus, abs=1e-6)


def test_a_sector_that_is_reversed_makes_what_it_can_t_be_told_to() -> None:
    """Ahead 100 N of each end, one of them reversed: nothing is left, though astern is outside the sector."""
    ferry = load_vehicle("double-ended-ferry")
    bow, stern = ferry.azimuths
    angles = np.radians([-60.0, -20.0, 20.0, 60.0])
    corners = np.vstack([[0.0, 0.0], 500.0 * np.column_stack([np.cos(angles), np.sin(angles)])])
    vehicle = replace(ferry, azimuths=(replace(bow, corners=corners), stern))
    taus = np.array([[200.0, 0.0, 0.0]])
    F = np.zeros((1, vehicle.n))
    F[:, [own[0] for own in vehicle.actuators]] = 100.0
    costs = {cost.failure: cost for cost in failure_costs(vehicle, "scaled", taus, F)}
    assert costs["reversed"].share_min == [0.0, 0.0]
    assert costs["off"].share_min == [0.5, 0.5]


def test_once_announced_what_can_be_met_is_met_and_the_rest_by_its_largest_share() -> None:
    vehicle, taus, _ = asked("supply-vessel")
    costs = {cost.failure: cost for cost in announced_costs(vehicle, taus)}
    for i in range(vehicle.n):
        reach = np.minimum(alpha_max(vehicle.with_fault(i), taus), 1.0)
        assert costs["off"].share_p50[i] == pytest.approx(np.median(reach), rel=1e-6)
        assert costs["off"].share_min[i] == pytest.approx(reach.min(), rel=1e-5)
        assert costs["off"].turned_max_deg[i] == 0.0


def test_a_method_without_answers_a_vehicle_with_one_thruster_left_and_one_uncovered_have_no_costs() -> None:
    vehicle, taus, F = asked("ukwial")
    assert failure_costs(vehicle, "x", taus, np.full_like(F, np.nan)) == []
    last = vehicle.with_fault(0).with_fault(1).with_fault(2)
    assert failure_costs(last, "x", taus, F) == announced_costs(last, taus) == []


def test_a_capability_has_the_costs_of_each_method_and_of_one_that_is_told() -> None:
    (capability,) = measure_capabilities([load_vehicle("ukwial")], ["pinv", "clip"], 0, ask_here, 50)
    found = [(cost.method, cost.failure) for cost in capability.failure_costs if not cost.announced]
    assert found == [(method, failure) for method in ("pinv", "clip") for failure in FAILURES]
    known = [cost for cost in capability.failure_costs if cost.announced]
    assert [(cost.method, cost.failure) for cost in known] == [("scaled", failure) for failure in FAILURES]
    assert all(cost.n_demands == 50 <= DEMANDS for cost in capability.failure_costs)
