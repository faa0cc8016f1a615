"""Labels and demand sets on vehicles with weak directions are of the strong part; else nothing changes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Label, Status, build, list_vehicles, load_vehicle
from alloc.formulations.scaled import straight
from alloc.reach.attainable import label
from bench.demands import build_demands, labelled
from bench.demands.store import pack_demands, unpack_demands
from bench.demands.strong import strong_demands, strong_vehicle, unasked_weak_axes, weak_directions

SURVEYED = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
PITCH = SURVEYED.dof.index("pitch")


@pytest.mark.parametrize("name", list_vehicles())
def test_without_weak_directions_vehicle_demands_and_labels_are_themselves(name: str) -> None:
    vehicle = load_vehicle(name)
    taus = np.random.default_rng(1).uniform(-1.0, 1.0, (9, vehicle.k)) * vehicle.wrench_scale
    for one in (vehicle, vehicle.with_fault(0)):
        assert strong_vehicle(one) is one
        assert strong_demands(one, taus) is unasked_weak_axes(one, taus) is taus
        assert weak_directions(one) == []
        made = labelled("made", one, taus)
        assert made.hard_alpha is made.hard_labels is None
        np.testing.assert_array_equal(made.alpha, label(one, taus).alpha)


@pytest.mark.parametrize("name", ["inactive", "active", "infeasible", "boundary", "axes", "box", "mission"])
def test_labels_are_what_scaled_delivers_and_hard_ones_what_nullspace_answers(name: str) -> None:
    demands = build_demands(name, SURVEYED, 3, 60)
    scaled, nullspace = build("scaled", SURVEYED), build("nullspace", SURVEYED)
    assert np.abs(demands.taus[:, PITCH]).max() <= 1e-9  # nobody asks for it
    assert demands.hard_labels is not None
    assert (demands.hard_labels == Label.INFEASIBLE).any()
    for tau, strong, hard in zip(demands.taus, demands.labels, demands.hard_labels, strict=True):
        if strong != Label.BOUNDARY:
            assert (scaled(tau).share == (1.0,)) == (strong != Label.INFEASIBLE)
        if hard != Label.BOUNDARY:
            assert (nullspace(tau).status is Status.SOLVED) == (hard != Label.INFEASIBLE)
    if name in ("inactive", "active", "infeasible", "boundary"):
        assert set(demands.labels) == {Label[name.upper()]}


def test_surge_that_eq_5_holds_back_is_easy_for_the_strong_part() -> None:
    demands = labelled("surge", SURVEYED, 30.0 * np.eye(6)[:1])
    assert demands.hard_alpha is not None
    assert demands.hard_alpha[0] == pytest.approx(0.3988, abs=1e-4)  # 12 N
    assert 4.0 < demands.alpha[0] < 4.5  # four thrusters at 40 N, but for a little pitch
    back = unpack_demands(pack_demands(demands))
    np.testing.assert_array_equal(back.hard_alpha, demands.hard_alpha)
    np.testing.assert_array_equal(back.hard_labels, demands.hard_labels)


def test_strong_part_is_what_scaled_delivers_of_a_demand() -> None:
    taus = np.random.default_rng(2).uniform(-1.0, 1.0, (20, 6)) * [20, 20, 20, 2, 2, 2]
    way = straight(SURVEYED)
    begin = way.departure(SURVEYED.f_min, SURVEYED.f_max)
    asked = strong_demands(SURVEYED, taus)
    np.testing.assert_allclose(way.delivered(taus, begin, np.ones((20, 1))), asked, atol=1e-9)
    plain = unasked_weak_axes(SURVEYED, taus)
    np.testing.assert_allclose(strong_demands(SURVEYED, plain), asked, atol=1e-9)
    assert not plain[:, PITCH].any()


def test_weak_directions_are_named_with_what_is_left_and_what_thrusts_make() -> None:
    (found,) = weak_directions(SURVEYED)
    assert found.words == "pitch (0.5 % left)"
    rng = np.random.default_rng(3)
    f = np.where(rng.random((4000, 6)) < 0.5, SURVEYED.f_min, SURVEYED.f_max)
    most = np.abs(f @ SURVEYED.TP.T @ SURVEYED.weak[0]).max()
    assert found.bound == pytest.approx(most, rel=1e-9)
    assert weak_directions(replace(SURVEYED, weak_limit=0.0)) == []
