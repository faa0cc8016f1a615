"""Weak directions: which they are, by the survey's tolerance, and the vehicle without them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, generate, list_vehicles, load_vehicle
from alloc.errors import VehicleError
from alloc.vehicle.weak import WEAK, Survey, doubts, six_rows
from bench.demands.store import pack_vehicle, same_vehicle, unpack_vehicle
from bench.demands.surveys import fail_thrusters, failures, hexarotor, move_poses
from tests.readers import written
from tests.vehicle_files import GOOD
from tests.vehicles import made_up

SHIPPED = [load_vehicle(name) for name in list_vehicles()]


@pytest.mark.parametrize("vehicle", [load_vehicle("bluerov2-heavy"), hexarotor()], ids=lambda v: v.name)
@pytest.mark.parametrize("survey", [Survey(), Survey(5.0, 0.5), Survey(0.0, 0.6), Survey(8.0, 0.0)])
def test_propagated_error_is_that_of_poses_drawn_at_random(vehicle: Vehicle, survey: Survey) -> None:
    rng, c = np.random.default_rng(1), np.eye(vehicle.k)
    drawn = [c @ (move_poses(vehicle, survey, rng).T - vehicle.T) for _ in range(300)]
    rms = np.sqrt(np.mean(np.square(drawn), axis=0))
    expected = np.sqrt(doubts(vehicle.T, vehicle.dof, survey, c))
    np.testing.assert_allclose(
        rms, expected, rtol=0.15, atol=3e-2 * expected.max()
    )  # turns are linear to 1 %


def test_entries_of_a_matrix_that_is_no_poses_err_by_a_share_of_their_row() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    c = np.eye(vehicle.k)
    expected = (0.02 * np.abs(vehicle.T).max(axis=1)) ** 2 / 3
    found = doubts(vehicle.T, vehicle.dof, Survey(relative=0.02), c)
    np.testing.assert_allclose(found, np.tile(expected[:, None], vehicle.n))
    uneven = vehicle.T * np.linspace(0.5, 1.0, vehicle.n)  # columns of another length are no thrusts
    relative = (0.01 * np.abs(uneven).max(axis=1)) ** 2 / 3
    found = doubts(uneven, vehicle.dof, Survey(), c)[:, :-1]
    np.testing.assert_allclose(found, np.tile(relative[:, None], vehicle.n - 1))


def test_poses_that_do_not_make_a_column_say_nothing_of_it() -> None:
    vehicle = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
    assert vehicle.poses is not None
    T = vehicle.T[[0, 4]] * [[1, 1, 1, 1.02, 1, 1], [1] * 6]
    whole = six_rows(T, ("surge", "pitch"), vehicle.poses)
    np.testing.assert_array_equal(whole[:, :3], vehicle.poses[:, :3])
    np.testing.assert_array_equal(whole[[0, 4], 3], T[:, 3])
    assert not whole[[1, 2, 3, 5], 3].any()
    with pytest.raises(VehicleError, match=r"poses has shape \(5, 6\)"):
        replace(vehicle, poses=vehicle.poses[:5])


def test_weak_directions_are_those_of_any_unit_of_thrust() -> None:
    """Poses were found in newtons only: of thrusts in per cent of full throttle the lost pitch counted."""
    newtons = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
    share = replace(newtons, T=newtons.T * 50, f_min=newtons.f_min / 50, f_max=newtons.f_max / 50)
    np.testing.assert_allclose(share.weak_left, newtons.weak_left)
    assert len(share.weak) == 1


def test_a_failure_that_leaves_nothing_strong_leaves_the_vehicle_as_it_is() -> None:
    """Code for each failure was refused where one of them takes all there is."""
    T, one = np.array([[1.0, 0.01, 0.0, 0.0]]), np.ones(1)
    vehicle = replace(load_vehicle("ukwial"), dof=("surge",), T=T, slack_weights=one, priority=(), groups=())
    degraded = vehicle.with_fault(0)
    assert len(degraded.weak) == vehicle.k
    assert degraded.strong is degraded
    assert generate(vehicle, "scaled", faults="one")


@pytest.mark.parametrize("survey", [Survey(), Survey(5.0, 0.5)], ids=lambda survey: survey.words)
@pytest.mark.parametrize("name", ["bluerov2", "bluerov2-heavy", "hexarotor"])
def test_lost_directions_as_surveyed_are_weak_and_no_others(name: str, survey: Survey) -> None:
    drawing = hexarotor() if name == "hexarotor" else load_vehicle(name)
    rng = np.random.default_rng(7)
    for off in failures(drawing, 2):
        nominal = fail_thrusters(drawing, off)
        found = fail_thrusters(replace(move_poses(drawing, survey, rng), survey=survey), off).directions
        with np.errstate(divide="ignore"):
            apart = found.sigma / found.epsilon
        assert apart[nominal.rank :].max(initial=0.0) <= WEAK < 6.0 < apart[: nominal.rank].min()


@pytest.mark.parametrize("vehicle", SHIPPED, ids=lambda vehicle: vehicle.name)
def test_a_drawing_is_its_own_strong_part(vehicle: Vehicle) -> None:
    for off in failures(vehicle, 2 if vehicle.name != "tiburon" else 1):
        degraded = fail_thrusters(vehicle, off)
        assert degraded.strong is degraded
        assert len(degraded.weak) == degraded.k - degraded.rank
        assert not degraded.weak_left.any()


def test_a_vehicle_without_a_thruster_that_pushes_has_lost_each_direction() -> None:
    """A campaign's vehicle 356, of which the share of nothing was 0 / 0."""
    degraded = made_up([[1.0, 0.0]], -9.0, 9.0).with_fault(0)
    assert degraded.weak_left.tolist() == [0.0]
    assert degraded.strong is degraded


def test_strong_part_loses_weak_directions_exactly_and_keeps_the_others() -> None:
    vehicle = move_poses(load_vehicle("bluerov2-heavy"), Survey(), np.random.default_rng(3))
    vehicle = vehicle.with_fault(4).with_fault(5)
    strong, (c,), (left,) = vehicle.strong, vehicle.weak, vehicle.weak_left
    assert 0.0 < left < 0.02
    assert np.linalg.norm(c * vehicle.directions.scale) == pytest.approx(1.0)
    assert (vehicle.rank, strong.rank) == (6, 5)
    assert np.abs(strong.TP - vehicle.TP).max() < 0.005  # no entry moves by more than a survey moves it
    np.testing.assert_allclose(c @ strong.TP, 0.0, atol=1e-15)
    far = np.maximum(np.abs(vehicle.f_min), vehicle.f_max)
    sigma = np.linalg.norm(c @ (vehicle.TP * far))
    np.testing.assert_allclose(sigma / vehicle.directions.sigma[0], left)
    assert strong.strong is strong
    assert strong.with_fault(0).strong.units is not None
    turned = vehicle.with_frame("frd" if vehicle.frame == "flu" else "flu").strong
    np.testing.assert_allclose(turned.with_frame(vehicle.frame).TP, strong.TP, atol=1e-12)


@pytest.mark.parametrize(("below", "count"), [(0.0, 0), (0.001, 0), (0.02, 1), (None, 1)])
def test_a_file_may_set_a_plain_share_instead(below: float | None, count: int) -> None:
    vehicle = move_poses(load_vehicle("bluerov2-heavy"), Survey(), np.random.default_rng(3))
    vehicle = replace(vehicle, weak_limit=below).with_fault(4).with_fault(5)
    assert len(vehicle.weak) == count
    assert (vehicle.strong is vehicle) == (count == 0)


def test_without_any_strong_direction_there_is_no_strong_part() -> None:
    vehicle = replace(load_vehicle("ukwial"), survey=Survey(relative=5.0))
    assert len(vehicle.weak) == vehicle.k
    with pytest.raises(VehicleError, match=r"every direction is weak: .*; give a finer 'survey'"):
        vehicle.strong  # noqa: B018  # a property that raises


@pytest.mark.parametrize(
    ("lines", "survey", "limit"),
    [
        ("", Survey(3.0, 0.3), None),
        ("survey: {mm: 5}\nweak: auto\n", Survey(5.0, 0.3), None),
        ("survey: {relative: 0.02}\nweak: 0.02\n", Survey(relative=0.02), 0.02),
        ("weak: 0\n", Survey(), 0.0),
    ],
)
def test_a_file_says_how_well_it_is_known_and_stores_and_copies_keep_it(
    lines: str, survey: Survey, limit: float | None, tmp_path: Path
) -> None:
    vehicle = load_vehicle(written(tmp_path / "mine.yaml", GOOD + lines))
    stored = unpack_vehicle(pack_vehicle(vehicle))
    for one in (
        vehicle,
        vehicle.with_fault(0),
        vehicle.with_frame("flu"),
        stored,
    ):
        assert (one.survey, one.weak_limit) == (survey, limit)
    assert same_vehicle(vehicle, stored)
    strong = move_poses(load_vehicle("bluerov2-heavy"), Survey(), np.random.default_rng(3))
    strong = strong.with_fault(4).with_fault(5).strong
    np.testing.assert_array_equal(unpack_vehicle(pack_vehicle(strong)).row_lengths, strong.row_lengths)
