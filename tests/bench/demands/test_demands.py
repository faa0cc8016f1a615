"""Demand sets hold what they are named after, for every vehicle, whole and with a fault."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Label, NotApplicable, Vehicle, alpha_max, list_vehicles, load_vehicle
from alloc.errors import UnknownName
from alloc.vehicle.current import Cap, PowerLaw
from alloc.vehicle.limits import Slew
from bench.demands import build_demands, list_demands
from bench.demands.store import Case, load_case, save_case
from tests.not_asked import not_asked
from tests.readers import written

WHOLE = [load_vehicle(name) for name in list_vehicles()]
STATES = WHOLE + [v.with_fault(0) for v in WHOLE]

vehicles = pytest.mark.parametrize("vehicle", STATES, ids=lambda v: v.name)


@vehicles
@pytest.mark.parametrize("name", ["inactive", "active", "boundary", "infeasible"])
def test_every_demand_carries_the_label_its_set_is_named_after(name: str, vehicle: Vehicle):
    if name == "active" and vehicle.nullity == 0:
        not_asked("no freedom, no active demand")
    demands = build_demands(name, vehicle, seed=1)
    assert len(demands.taus) == 1000
    assert set(demands.labels) == {Label[name.upper()]}


@vehicles
def test_infeasible_demands_exceed_the_edge_by_2_to_100_percent(vehicle: Vehicle):
    beyond = 1 / build_demands("infeasible", vehicle, seed=1).alpha
    assert 1.02 <= beyond.min() < 1.03
    assert 1.95 < beyond.max() <= 2.0


@vehicles
def test_boundary_demands_lie_on_both_sides_and_in_every_decade(vehicle: Vehicle):
    outside = 1 - build_demands("boundary", vehicle, seed=1).alpha
    for side in (-outside[outside < 0], outside[outside > 0]):
        assert len(side) == 500
        counts, _ = np.histogram(side, [1e-5 * 0.99, 1e-4, 1e-3 * 1.01])
        assert counts.min() > 200


@vehicles
def test_the_box_set_fills_the_box_of_single_axis_maxima(vehicle: Vehicle):
    taus = build_demands("box", vehicle, seed=1, n=2000).taus
    forward = alpha_max(vehicle, np.eye(vehicle.k))
    assert (taus.max(axis=0) <= forward).all()
    assert (taus.max(axis=0) >= 0.98 * forward).all()


@vehicles
def test_the_axes_set_asks_one_axis_at_a_time_across_both_edges(vehicle: Vehicle):
    demands = build_demands("axes", vehicle, seed=1)
    assert (np.count_nonzero(demands.taus, axis=1) <= 1).all()
    if vehicle.rank == vehicle.k:
        for axis in range(vehicle.k):
            asked = demands.taus[:, axis] != 0
            assert (demands.alpha[asked] < 1).any()
            assert (demands.alpha[asked] > 1).any()


@pytest.mark.parametrize("name", list_demands())
def test_one_seed_gives_one_set_and_another_seed_another(name: str):
    # Its file says slew rates and voltage, which some sets need as one needs a cap.
    vehicle = replace(load_vehicle("bluerov2"), cap=Cap(20.0, volts=12.0))
    one, again, other = (build_demands(name, vehicle, seed, n=40).taus for seed in (1, 1, 2))
    assert np.array_equal(one, again)
    assert name == "axes" or not np.array_equal(one, other)


def test_two_sets_and_two_vehicles_of_one_seed_share_no_random_numbers():
    ukwial = load_vehicle("ukwial")
    renamed = replace(ukwial, name="another")
    directions = [
        taus / np.linalg.norm(taus, axis=1, keepdims=True)
        for taus in (
            build_demands("inactive", ukwial, 1, n=5).taus,
            build_demands("infeasible", ukwial, 1, n=5).taus,
            build_demands("inactive", renamed, 1, n=5).taus,
        )
    ]
    assert not np.allclose(directions[0], directions[1])
    assert not np.allclose(directions[0], directions[2])


def test_a_vehicle_without_freedom_has_no_active_set_and_the_message_says_why():
    with pytest.raises(NotApplicable, match=r"d = n - rank T = 0"):
        build_demands("active", load_vehicle("ukwial").with_fault(0), seed=1)


def test_a_vehicle_that_must_always_thrust_has_no_box_or_axes_set_and_the_message_says_why():
    forced = replace(load_vehicle("ukwial"), f_min=[10.0, 10, 10, 20], f_max=[11.0, 11, 11, 30])
    for name in ("box", "axes"):
        with pytest.raises(NotApplicable, match="zero"):
            build_demands(name, forced, seed=1)


def test_an_unknown_set_is_refused_with_the_known_names():
    with pytest.raises(UnknownName, match="inactive"):
        build_demands("nonesuch", load_vehicle("ukwial"), seed=1)


def test_a_file_that_happens_to_be_called_like_a_set_is_not_taken_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    meant = build_demands("active", load_vehicle("ukwial"), seed=3, n=5)
    (tmp_path / "active").write_text("surge,sway,yaw\n1,2,3\n")
    monkeypatch.chdir(tmp_path)
    np.testing.assert_array_equal(build_demands("active", load_vehicle("ukwial"), 3, 5).taus, meant.taus)
    assert build_demands("./active", load_vehicle("ukwial"), 3, 5).taus.tolist() == [[1.0, 2.0, 3.0]]


def test_the_demands_of_a_set_are_read_only():
    demands = build_demands("inactive", load_vehicle("ukwial"), seed=1, n=3)
    with pytest.raises(ValueError, match="read-only"):
        demands.taus[0] = 0


def test_a_vehicle_survives_the_file_it_is_handed_over_in_with_its_moving_limits(tmp_path: Path) -> None:
    slow = replace(
        load_vehicle("bluerov2-heavy"), slew=Slew(up=np.full(8, 4.0), down=np.full(8, 9.0))
    ).with_fault(2)
    save_case(tmp_path / "case.npz", Case(slow, np.ones((2, 6))))
    again, taus, f_min, f_max = load_case(tmp_path / "case.npz")
    assert (again.name, again.whole, again.dof) == (slow.name, slow.whole, slow.dof)
    assert (again.priority, again.names) == (slow.priority, slow.names)
    assert len(again.priority) == 3
    assert taus.shape == (2, 6)
    assert f_min is f_max is None
    moment = {"volts": 13.0, "f_previous": np.ones(8), "dt": 0.1}
    np.testing.assert_array_equal(again.limits(**moment), slow.limits(**moment))


def test_a_stored_vehicle_sends_the_same_commands(tmp_path: Path) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    save_case(tmp_path / "case.npz", Case(vehicle, np.zeros((1, vehicle.k))))
    stored = load_case(tmp_path / "case.npz").vehicle
    f = np.linspace(-39, 51, vehicle.n)
    assert np.array_equal(stored.commands(f, 14.2).u, vehicle.commands(f, 14.2).u)


@pytest.mark.parametrize("law", [True, False])
def test_a_stored_vehicle_draws_the_same_currents_and_keeps_its_cap(tmp_path: Path, *, law: bool) -> None:
    vehicle = replace(load_vehicle("bluerov2-heavy"), cap=Cap(300.0, 30.0, True, 15.0))
    if law:
        escs = [replace(esc, current=PowerLaw(0.07, 0.1 + i / 100, 1.5)) for i, esc in enumerate(vehicle.esc)]
        vehicle = replace(vehicle, esc=tuple(escs))
    save_case(tmp_path / "case.npz", Case(vehicle, np.zeros((1, vehicle.k))))
    stored = load_case(tmp_path / "case.npz").vehicle
    f = np.linspace(vehicle.f_min, vehicle.f_max, 30)
    assert np.array_equal(stored.draw(14.2).amps(f), vehicle.draw(14.2).amps(f))
    assert stored.cap == vehicle.cap


def test_a_log_that_is_cut_still_says_how_many_of_its_demands_cannot_be_met(tmp_path: Path) -> None:
    log = tmp_path / "dive.csv"
    surges = [10, 20, 5000, 30, 5000, 5000, 40]
    log.write_text("surge,sway,yaw\n" + "".join(f"{surge},0,0\n" for surge in surges))
    demands = build_demands(log, load_vehicle("ukwial"), 0, 2)
    assert (len(demands.taus), demands.left_out) == (2, 5)
    assert (demands.beyond, demands.beyond_longest) == (3, 2)


def test_limits_of_a_log_that_cross_are_counted_apart_from_what_can_not_be_met_and_said(
    tmp_path: Path,
) -> None:
    axes = ",".join(load_vehicle("bluerov2-heavy").dof)
    rows = [
        "1,0,0,0,0,0,-9,9",
        "9e9,0,0,0,0,0,-9,9",
        "0,0,0,0,0,0,5.1,5",
        "1,0,0,0,0,0,5,5",
        "1,0,0,0,0,0,6,5",
    ]
    path = written(tmp_path / "dive.csv", "\n".join([f"{axes},f0_min,f0_max", *rows]) + "\n")
    dive = build_demands(path, load_vehicle("bluerov2-heavy"), seed=1, n=3)
    assert (dive.crossed, dive.beyond, dive.left_out) == (2, 1, 2)
    assert dive.crossing.tolist() == [False, False, True]
    assert "limits cross in 2 of 5 demands, first in demand 2 " in dive.notes[-1]
