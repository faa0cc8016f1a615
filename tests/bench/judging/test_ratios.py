"""Ratios of readiness from simulated dives of vehicles whose mass nobody states."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import load_vehicle
from bench.judging.ratios import estimate_ratios, groups
from tests.dives import dive


@pytest.mark.parametrize(("name", "thruster", "readiness"), [("bluerov2", 4, 0.5), ("ukwial", 1, -1.0)])
def test_a_weak_thruster_is_found_without_the_mass(name: str, thruster: int, readiness: float) -> None:
    vehicle = replace(load_vehicle(name), inertia=None)
    truth = np.ones(vehicle.n)
    truth[thruster] = readiness
    flown = dive(vehicle, np.random.default_rng(thruster), truth, noise=0.05)
    ratios, half_width = estimate_ratios(vehicle, flown.f, flown.a, flown.v)
    assert ratios == pytest.approx(truth, abs=0.05)  # the median of the others is 1
    assert (half_width < 0.05).all()


def test_a_heavier_vehicle_with_stronger_thrusters_has_the_same_ratios() -> None:
    vehicle = load_vehicle("ukwial")
    flown = dive(vehicle, np.random.default_rng(2), np.array([1.0, 0.8, 0.6, 1.0]))
    ratios, half_width = estimate_ratios(vehicle, flown.f, flown.a, flown.v)
    others, widths = estimate_ratios(vehicle, 1.3 * flown.f, flown.a, flown.v)
    assert others == pytest.approx(ratios, abs=1e-4)
    assert widths == pytest.approx(half_width, rel=1e-2)


def test_thrusters_that_push_no_common_axis_are_not_compared() -> None:
    assert groups(load_vehicle("bluerov2-heavy")).tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    vehicle = load_vehicle("ukwial")
    alone = replace(
        vehicle, T=np.eye(3), H=np.eye(3), f_min=vehicle.f_min[:3], f_max=vehicle.f_max[:3],
        readiness=np.ones(3), names=(),
        slew=None, by_volts=None, esc=(), poses=None, priority=(), groups=(), autopilot=None,
    )  # fmt: skip
    flown = dive(alone, np.random.default_rng(1), np.ones(3))
    ratios, half_width = estimate_ratios(alone, flown.f, flown.a, flown.v)
    assert np.isnan(ratios).all()
    assert np.isinf(half_width).all()


def test_nothing_is_said_of_a_vehicle_that_does_not_move() -> None:
    vehicle = load_vehicle("ukwial")
    flown = dive(vehicle, np.random.default_rng(3), np.ones(4))
    assert np.isinf(estimate_ratios(vehicle, flown.f, 0 * flown.a, 0 * flown.v)[1]).all()
