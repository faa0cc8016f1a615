"""The mission: the body's equations against conservation laws, and what its two demand sets hold."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from alloc import Label, NotApplicable, Vehicle, load_vehicle
from alloc.reach.attainable import single_axis_maxima
from alloc.vehicle.geometry import DOF
from bench.demands import DemandSet, build_demands, mission
from bench.demands.mission import HALF, STEPS, fly

NAMES = ["ukwial", "bluerov2-heavy"]
"""A planar vehicle and one with all degrees of freedom; a flight takes a second."""
vehicles = pytest.mark.parametrize("name", NAMES)


@cache
def sets(name: str) -> tuple[DemandSet, DemandSet]:
    vehicle = load_vehicle(name)
    return build_demands("mission", vehicle, 1), build_demands("mission-fault", vehicle, 1)


@pytest.mark.parametrize("set_name", ["mission", "mission-fault"])
@pytest.mark.parametrize("name", NAMES)
def test_a_mission_that_is_judged_whole_is_timed_on_the_part_that_was_asked_alone(
    name: str, set_name: str
) -> None:
    vehicle = load_vehicle(name)
    whole = build_demands(set_name, vehicle, 1, 60, whole=True)
    alone = build_demands(set_name, vehicle, 1, 60)
    assert (len(whole.taus), whole.left_out) == (HALF, 0)
    assert (len(alone.taus), alone.left_out) == (60, HALF - 60)
    assert whole.part is not None
    np.testing.assert_array_equal(whole.taus[slice(*whole.part)], alone.taus)
    np.testing.assert_array_equal(whole.taus, sets(name)[set_name == "mission-fault"].taus)
    assert build_demands(set_name, vehicle, 1, HALF, whole=True).part is None


def test_coriolis_forces_do_no_work():
    rng = np.random.default_rng(1)
    for v in rng.normal(size=(20, 6)):
        drag = (mission.LINEAR + mission.QUADRATIC * np.abs(v)) * v
        assert v @ (mission.resistance(v) - drag) == pytest.approx(0, abs=1e-10)


def test_drag_alone_takes_energy_in_every_direction():
    for v in np.vstack([np.eye(6), -np.eye(6)]):
        assert v @ mission.resistance(v) > 0


def test_weight_and_buoyancy_pull_along_the_vertical_at_any_attitude():
    for yaw in (0.0, 1.0, -2.0):
        roll, pitch = 0.3, -0.4
        force = (
            mission.rotation(np.array([roll, pitch, yaw]))
            @ mission.restoring(np.array([roll, pitch, yaw]))[:3]
        )
        assert force == pytest.approx([0, 0, -(mission.WEIGHT - mission.BUOYANCY)], abs=1e-12)


def test_a_tilted_body_is_turned_back_upright():
    for tilt in (0.2, -0.2):
        assert -mission.restoring(np.array([tilt, 0, 0]))[3] * tilt < 0
        assert -mission.restoring(np.array([0, tilt, 0]))[4] * tilt < 0


def test_attitude_rates_are_those_of_the_rotation_matrix():
    attitude, w, dt = np.array([0.3, -0.5, 1.2]), np.array([0.4, -0.3, 0.7]), 1e-7
    turned = mission.rotation(attitude + dt * mission.euler_rates(attitude, w))
    skew = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    expected = mission.rotation(attitude) @ (np.eye(3) + dt * skew)  # R' = R S(w)
    np.testing.assert_allclose(turned, expected, atol=1e-12)


@vehicles
def test_mission_and_mission_fault_are_one_flight_cut_at_the_failure(name: str):
    before, after = sets(name)
    assert before.taus.shape == after.taus.shape == (HALF, load_vehicle(name).k)
    assert before.rate_hz == after.rate_hz == 100
    assert before.vehicle.name == name
    assert len(after.vehicle.working) == len(before.vehicle.working) - 1
    # The step across the failure is no larger than usual between two demands while the vehicle keeps station.
    jumps = np.abs(np.diff(before.taus[-100:], axis=0)).max(axis=0)
    assert (np.abs(after.taus[0] - before.taus[-1]) <= 3 * jumps).all()


@vehicles
def test_demands_stay_within_what_each_axis_reaches_alone(name: str):
    backward, forward = single_axis_maxima(load_vehicle(name))
    for demands in sets(name):
        assert (demands.taus >= backward).all()
        assert (demands.taus <= forward).all()


@vehicles
def test_successive_demands_are_close(name: str):
    for demands in sets(name):
        scaled = demands.taus / demands.taus.std(axis=0)
        assert np.median(np.abs(np.diff(scaled, axis=0))) < 0.1  # independent ones would differ by about 1


def test_missions_have_inactive_active_and_infeasible_demands():
    labels = np.concatenate([part.labels for name in NAMES for part in sets(name)])
    assert {Label.INACTIVE, Label.ACTIVE, Label.INFEASIBLE} <= set(labels)


@vehicles
def test_the_vehicle_arrives_and_keeps_station_until_the_thruster_fails(name: str):
    vehicle = load_vehicle(name)
    flight = fly(vehicle, vehicle, np.random.default_rng(3), HALF)
    settled = flight.poses[HALF - 300 :]
    assert np.ptp(settled[:, :3], axis=0).max() < 0.3  # m
    assert np.abs(settled[:, 3:5]).max() < 0.4  # rad


def test_a_failure_changes_the_flight_after_it_and_not_before():
    ukwial = load_vehicle("ukwial")
    well, failed = (fly(ukwial, v, np.random.default_rng(3)) for v in (ukwial, ukwial.with_fault(0)))
    assert np.array_equal(well.poses[: HALF + 1], failed.poses[: HALF + 1])
    assert np.abs(well.poses[HALF:] - failed.poses[HALF:]).max() > 0.1  # m


def test_an_axis_that_is_not_controlled_stays_where_it_is():
    ukwial = load_vehicle("ukwial")
    poses = fly(ukwial, ukwial, np.random.default_rng(3), HALF).poses
    assert (poses[:, 2:5] == 0).all()
    assert np.ptp(poses[:, [0, 1, 5]], axis=0).min() > 0.5


def test_a_short_mission_lies_around_the_moment_at_which_the_vehicle_can_follow_again():
    """After the first waypoint it is asked for too much at first; before and after, there is some of both."""
    vehicle = load_vehicle("bluerov2-heavy")
    whole, part = (build_demands("mission", vehicle, 1, n) for n in (None, 100))
    (start,) = (
        i for i in range(STEPS[0] - 50, HALF - 100) if np.array_equal(part.taus, whole.taus[i : i + 100])
    )
    assert start + 50 >= STEPS[0]
    assert {Label.INFEASIBLE} == set(whole.labels[STEPS[0] : start + 49])
    assert part.labels[50] != Label.INFEASIBLE


def test_a_vehicle_with_one_thruster_has_no_mission_fault_set():
    one = Vehicle(
        name="one",
        dof=("surge",),
        T=np.eye(1),
        H=np.eye(1),
        f_min=[-1.0],
        f_max=[1.0],
        readiness=[1.0],
        slack_weights=[1.0],
    )
    with pytest.raises(NotApplicable, match="one thruster"):
        build_demands("mission-fault", one, 1)


@pytest.mark.parametrize("name", ["bluerov2", "bluerov2-heavy"])  # in flu and in frd
@pytest.mark.parametrize("axis", ["surge", "sway", "heave"])
def test_a_move_ends_where_it_was_to_end_and_what_turns_the_vehicle_is_seen(name: str, axis: str) -> None:
    vehicle = load_vehicle(name)
    place = DOF.index(axis)
    straight = mission.move(vehicle, axis, -3.0, 500, lambda tau: tau).poses
    assert straight[-1, place] == pytest.approx(-3.0, abs=0.3)
    assert np.delete(straight, place, axis=1) == pytest.approx(0.0, abs=1e-9)
    yaw = vehicle.dof.index("yaw")
    aside = np.eye(vehicle.k)[yaw] * (1 if vehicle.frame == "frd" else -1)
    for given in (None, 3 * mission.M):  # a file without inertia gets the BlueROV2 Heavy's
        flown = replace(vehicle, inertia=given)
        turned = mission.move(flown, axis, -3.0, 10, lambda tau: aside).poses  # 1 N m, and nothing else
        t = np.arange(10) / 100
        inertia = (mission.M if given is None else given)[5]
        assert turned[:, 5] == pytest.approx(t * (t + 0.01) / (2 * inertia), rel=0.01)
