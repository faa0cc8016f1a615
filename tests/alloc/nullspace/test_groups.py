"""``scaled-by-group``: each group of axes goes straight towards its demand, whatever the others ask for."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import linprog

from alloc import Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.c import missing
from alloc.errors import VehicleError
from alloc.formulations import find_formulation
from alloc.reach.attainable import alpha_max_lp
from alloc.reach.way import KEEP, separations
from alloc.vehicle.weak import DRAWN
from bench.demands.surveys import move_poses

TIBURON = load_vehicle("tiburon")
GROUPS = (("heave", "roll", "pitch"), ("surge", "sway", "yaw"))
"""Those of ArduSub and of what tiburon flew; its thrusters of the plane push roll and pitch a little."""


def demands(vehicle: Vehicle, count: int) -> FloatArray:
    rng = np.random.default_rng(34439)
    f = rng.uniform(vehicle.f_min, vehicle.f_max, (count, vehicle.n)) * rng.uniform(0.5, 3.0, (count, 1))
    return f @ vehicle.TP.T


def shares_of_programs(vehicle: Vehicle, tau: FloatArray, low: FloatArray, high: FloatArray) -> list[float]:
    """Group by group the largest s for which w + s (step of the group) is made inside limits."""
    w, shares = np.zeros(vehicle.k), []
    for j, group in enumerate(vehicle.groups):
        axes = [vehicle.dof.index(axis) for axis in group]
        step = np.zeros(vehicle.k)
        step[axes] = tau[axes]
        columns = np.hstack([vehicle.TP, -step[:, None]])
        ends = [*zip(low, high, strict=True), (0.0, 1e3)]
        found = linprog(np.r_[np.zeros(vehicle.n), -1.0], A_eq=columns, b_eq=w, bounds=ends)
        kept = 1.0 if j == len(vehicle.groups) - 1 else KEEP
        shares.append(min(1.0, kept * float(found.x[-1])))
        w += shares[-1] * step
    return shares


@pytest.mark.parametrize("method", ["scaled-by-group", "scaled-by-group@native"])
def test_groups_that_share_thrusters_take_turns_as_far_as_linear_programs_go(method: str) -> None:
    if "native" in method and missing():
        pytest.skip(missing())
    vehicle = replace(TIBURON, groups=GROUPS)
    allocate = build(method, vehicle)
    for i, tau in enumerate(demands(vehicle, 20)):
        narrower = 1.0 if i % 2 else 0.6
        low, high = narrower * vehicle.f_min, narrower * vehicle.f_max
        result = allocate(tau) if i % 2 else allocate(tau, f_min=low, f_max=high)
        # HiGHS keeps its rows to 1e-7.
        np.testing.assert_allclose(result.share, shares_of_programs(vehicle, tau, low, high), atol=1e-6)
        delivered = np.zeros(vehicle.k)
        for share, group in zip(result.share, GROUPS, strict=True):
            axes = [vehicle.dof.index(axis) for axis in group]
            delivered[axes] = share * tau[axes]
        np.testing.assert_allclose(vehicle.TP @ result.f, delivered, atol=1e-8)
        assert (low <= result.f).all()
        assert (result.f <= high).all()
        assert (result.status is Status.SOLVED) == (min(result.share) == 1.0)


@pytest.mark.parametrize("method", ["scaled-by-group", "scaled-by-group@native"])
def test_groups_that_only_noise_couples_start_at_once_and_are_shortened_until_they_fit(method: str) -> None:
    """Shares by linear programs of another kind than the facets: each group alone, then all of them."""
    if "native" in method and missing():
        pytest.skip(missing())
    rng = np.random.default_rng(38)
    vehicle = move_poses(load_vehicle("bluerov2-heavy"), DRAWN, rng)
    groups = separations(vehicle)[0][1]
    assert len(groups) == 2
    allocate, shortened = build(method, vehicle), 0
    for i, tau in enumerate(demands(vehicle, 20)):
        narrower = 1.0 if i % 2 else 0.6
        low, high = narrower * vehicle.f_min, narrower * vehicle.f_max
        result = allocate(tau) if i % 2 else allocate(tau, f_min=low, f_max=high)
        steps = [np.where([axis in group for axis in vehicle.dof], tau, 0.0) for group in groups]
        alone = [min(1.0, alpha_max_lp(vehicle, step, low, high)) for step in steps]
        end = alone @ np.array(steps)
        factor = min(1.0, alpha_max_lp(vehicle, end, low, high))
        shortened += factor < 1.0 - 1e-6
        np.testing.assert_allclose(result.share, factor * np.array(alone), atol=1e-6)
        np.testing.assert_allclose(vehicle.TP @ result.f, factor * end, atol=1e-8)
    assert shortened


def test_a_fault_changes_no_number_of_shares() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    way = find_formulation("scaled-by-group").way
    assert way is not None
    levels = {way(each).levels for each in (vehicle, *map(vehicle.with_fault, range(vehicle.n)))}
    assert levels == {(("surge", "sway", "yaw"), ("heave", "roll", "pitch"))}


def test_groups_without_a_common_thruster_leave_nothing_and_are_exact_in_any_order() -> None:
    vehicle = replace(load_vehicle("bluerov2-heavy"), groups=GROUPS)
    rule = find_formulation("scaled-by-group")
    assert rule.optimal_for(vehicle)
    assert not rule.optimal_for(replace(TIBURON, groups=GROUPS))
    taus = demands(vehicle, 50)
    turned = replace(vehicle, groups=GROUPS[::-1])
    first, second = (build("scaled-by-group", each).many(taus)[0] for each in (vehicle, turned))
    np.testing.assert_allclose(first, second, atol=1e-9 * vehicle.f_scale)


def test_thrusts_are_continuous_where_groups_share_thrusters() -> None:
    vehicle = replace(TIBURON, groups=GROUPS)
    begin, end = demands(vehicle, 2)
    line = begin + np.linspace(0.0, 1.0, 2001)[:, None] * (end - begin)
    F, _ = build("scaled-by-group", vehicle).many(line)
    steps = [float(np.abs(b - a).max()) for a, b in pairwise(F)]
    assert max(steps) < 0.05 * vehicle.f_scale  # 2,000 steps of a demand that moves by a few f_scale


@pytest.mark.parametrize(
    ("groups", "says"),
    [
        ([["surge", "sway"]], "yaw is missing"),
        ([["surge", "sway"], ["yaw", "surge"]], "surge stands twice"),
        ([["surge", "sway", "yaw"], []], "group 2 is empty"),
        ([["surge", "sway", "yaw", "heave"]], "'heave' does not stand in 'dof'"),
    ],
)
def test_groups_name_every_axis_once(groups: list[list[str]], says: str) -> None:
    with pytest.raises(VehicleError, match=says):
        replace(load_vehicle("ukwial"), groups=tuple(map(tuple, groups)))
