"""Readiness from simulated dives, with the mass and without: right within its intervals, nobody accused."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from bench.demands.mission import M
from bench.judging.readiness import (
    WindowReadiness,
    estimate_ratios,
    estimate_readiness,
    estimate_windows,
    groups,
    neighbour_velocity,
)
from dives import body, fly
from tests.dives import dive


def heavy() -> Vehicle:
    return load_vehicle("bluerov2-heavy")  # flies its own body: its file has the inertia of the source


def one(i: int, readiness: float, n: int = 8) -> FloatArray:
    p = np.ones(n)
    p[i] = readiness
    return p


def only_window(vehicle: Vehicle, seed: int, readiness: FloatArray, noise: float = 0.05) -> WindowReadiness:
    flown = dive(vehicle, np.random.default_rng(seed), readiness, noise=noise)
    (window,) = estimate_windows(vehicle, *flown, estimate_readiness)
    return window


@pytest.mark.parametrize(("thruster", "readiness"), [(2, 0.0), (5, 0.5), (7, -1.0), (0, 0.6)])
def test_a_weak_thruster_is_named_and_no_other(thruster: int, readiness: float) -> None:
    window = only_window(heavy(), thruster, one(thruster, readiness))
    assert window.accused == [thruster]
    assert window.p[thruster] == pytest.approx(readiness, abs=0.05)


@pytest.mark.parametrize("noise", [0.02, 0.2])
def test_nobody_is_accused_on_a_healthy_dive(noise: float) -> None:
    for seed in range(3):
        assert only_window(heavy(), 100 + seed, np.ones(8), noise).accused == []


@pytest.mark.long
@pytest.mark.parametrize("name", ["bluerov2-heavy", "bluerov2"])
def test_intervals_hold_the_truth_in_about_95_percent_of_cases(name: str) -> None:
    vehicle = replace(load_vehicle(name), inertia=M)
    inside = []
    for seed in range(12):
        truth = np.random.default_rng(seed).uniform(0.0, 1.0, vehicle.n)
        flown = dive(vehicle, np.random.default_rng(seed), truth, noise=0.05)
        p, half_width = estimate_readiness(vehicle, flown.f, flown.a, flown.v)
        inside += (np.abs(p - truth) <= half_width).tolist()
    assert 0.90 <= np.mean(inside) <= 0.995


def test_neither_a_current_nor_noise_that_is_fed_back_shifts_estimates() -> None:
    plain = load_vehicle("ukwial")
    size = body(plain)
    vehicle, rng = replace(plain, inertia=size * M), np.random.default_rng(21)
    truth = rng.uniform(0.0, 1.0, (60, vehicle.n))
    flight = fly(vehicle, rng, truth, current=0.2, size=size, gain=2.0)
    off = []
    for p, f, a, v in zip(truth, *flight[1:], strict=True):
        found, half_width = estimate_readiness(vehicle, f, a, neighbour_velocity(flight.t, a, v))
        off += ((found - p) / half_width * 1.96).tolist()
    assert abs(np.mean(off)) < 0.25  # standard deviations; 240 cases


def test_the_neighbour_velocity_of_a_row_follows_slopes_that_jump_and_not_the_rows_noise() -> None:
    rng = np.random.default_rng(1)
    t, a = np.cumsum(rng.uniform(0.02, 0.08, 50)), rng.normal(size=(50, 2))
    v = np.vstack([np.zeros(2), np.cumsum(a[:-1] * np.diff(t)[:, None], axis=0)])
    assert neighbour_velocity(t, a, v) == pytest.approx(v)
    noisy = v.copy()
    noisy[20] += 1.0
    assert neighbour_velocity(t, a, noisy)[20] == pytest.approx(v[20])
    assert np.isfinite(neighbour_velocity(np.zeros(50), a, v)).all()


def test_a_thruster_that_was_never_asked_has_no_readiness() -> None:
    vehicle = heavy()
    flown = dive(vehicle, np.random.default_rng(3), np.ones(8))
    f = flown.f.copy()
    f[:, 4] = 0.0
    p, half_width = estimate_readiness(vehicle, f, flown.a, flown.v)
    assert np.isnan(p[4])
    assert half_width[4] == np.inf
    assert np.isfinite(np.delete(p, 4)).all()


def test_a_window_without_motion_says_nothing_and_a_short_one_is_left_out() -> None:
    vehicle, t = heavy(), np.arange(0, 25, 0.05)
    still = np.zeros((len(t), vehicle.k))
    (window,) = estimate_windows(vehicle, t, np.zeros((len(t), 8)), still, still, estimate_readiness)
    assert window.is_vague
    assert window.accused == []
    short = t[:100], np.zeros((100, 8)), still[:100], still[:100]
    assert list(estimate_windows(vehicle, *short, estimate_readiness)) == []


def test_the_file_of_the_bluerov2_heavy_has_the_inertia_of_the_body_that_missions_fly() -> None:
    assert heavy().inertia == pytest.approx(M)


def test_a_vehicle_without_inertia_is_refused() -> None:
    with pytest.raises(VehicleError, match="ukwial: has no 'inertia'"):
        estimate_readiness(load_vehicle("ukwial"), *np.zeros((3, 10, 4)))


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
