"""Failures that nobody announces: what shows, what looks alike, and what a demand tells apart."""

from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest

from alloc import Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.lint.isolation import SEPARATION, Isolation, as_text, assumed_noise, isolation

VEHICLES = list_vehicles()


@cache
def found(name: str) -> tuple[Vehicle, Isolation]:
    vehicle = load_vehicle(name)
    return vehicle, isolation(vehicle)


def separation(columns: FloatArray, f: FloatArray, i: int, j: int) -> float:
    """Least that either failure leaves across the line of the other, columns (k, n) over noise [-]."""
    a, b = columns[:, i] * f[i], columns[:, j] * f[j]
    return min(float(np.linalg.norm(x - (x @ y) / (y @ y) * y)) for x, y in ((a, b), (b, a)))


def named(vehicle: Vehicle, pair: tuple[str, str]) -> tuple[int, int]:
    i, j = ([vehicle.called(i) for i in range(vehicle.n)].index(name) for name in pair)
    return i, j


@pytest.mark.parametrize("name", VEHICLES)
def test_each_pair_is_either_alike_or_told_apart_once(name: str) -> None:
    vehicle, result = found(name)
    pairs = [pair for trial in result.trials for pair in trial.pairs] + [each[:2] for each in result.alike]
    assert sorted(named(vehicle, pair) for pair in pairs) == list(combinations(range(vehicle.n), 2))


@pytest.mark.parametrize("name", VEHICLES)
def test_a_trial_is_within_limits_and_the_exact_answer_to_it_is_the_one_that_is_believed(name: str) -> None:
    vehicle, result = found(name)
    for trial in result.trials:
        assert (trial.f >= vehicle.f_min - 1e-6 * vehicle.f_scale).all()
        assert (trial.f <= vehicle.f_max + 1e-6 * vehicle.f_scale).all()
        assert build("scaled", vehicle)(trial.tau).f == pytest.approx(trial.f, abs=1e-6 * vehicle.f_scale)


@pytest.mark.parametrize("name", VEHICLES)
def test_a_trial_is_just_large_enough_for_all_its_pairs(name: str) -> None:
    vehicle, result = found(name)
    columns = vehicle.TP / result.noise[:, None]
    for trial in result.trials:
        sizes = [separation(columns, trial.f, *named(vehicle, pair)) for pair in trial.pairs]
        assert min(sizes) == pytest.approx(SEPARATION)


@pytest.mark.parametrize("name", ["ukwial", "bluerov2", "bluerov2-heavy"])
def test_a_dead_thruster_is_named_right_in_95_percent_of_cases_between_any_two(name: str) -> None:
    vehicle, result = found(name)
    rng, columns = np.random.default_rng(1), vehicle.TP / result.noise[:, None]
    units = columns / np.linalg.norm(columns, axis=0)
    for trial in result.trials:
        for pair in trial.pairs:
            for i, j in (named(vehicle, pair), named(vehicle, pair)[::-1]):
                residuals = -columns[:, i] * trial.f[i] + rng.normal(size=(1000, vehicle.k))
                along_i, along_j = (np.abs(residuals @ units[:, each]) for each in (i, j))
                assert np.mean(along_i > along_j) >= 0.94  # 1,000 cases: 95 % less two deviations


def test_columns_that_are_parallel_look_alike_at_any_noise() -> None:
    vehicle = load_vehicle("ukwial")
    T = vehicle.T.copy()
    T[:, 1] = -0.5 * T[:, 0]
    twin = replace(vehicle, T=np.hstack([T, vehicle.T[:, [1]]]), H=np.eye(5), f_min=np.full(5, -250.0),
                   f_max=np.full(5, 250.0), readiness=np.ones(5), poses=None, slew=None)  # fmt: skip
    result = isolation(twin, np.full(3, 1e-6))
    assert [(a, b) for a, b, _ in result.alike] == [("thruster 0", "thruster 1")]
    assert "thruster 0 and thruster 1: no demand" in as_text(twin, result)


def test_the_smallest_loss_that_shows_grows_with_the_noise_and_is_that_of_the_largest_thrust() -> None:
    vehicle, result = found("bluerov2-heavy")
    twice = isolation(vehicle, 2 * result.noise)
    for one, two in zip(result.shows, twice.shows, strict=True):
        assert two.loss == pytest.approx(2 * one.loss)
    # No demand makes a thruster push more than its limit.
    lengths = np.linalg.norm(vehicle.T / result.noise[:, None], axis=0)
    for i, each in enumerate(result.shows):
        assert each.loss >= SEPARATION / (lengths[i] * vehicle.f_max[i]) * (1 - 1e-9)


def test_in_much_noise_nothing_shows_and_every_pair_is_alike() -> None:
    vehicle = load_vehicle("ukwial")
    result = isolation(vehicle, 1000 * assumed_noise(vehicle))
    assert result.trials == ()
    assert len(result.alike) == 6
    assert as_text(vehicle, result).count("not even reversed") == 4


def test_a_thruster_that_is_off_is_not_looked_at_and_one_left_has_no_pairs() -> None:
    vehicle = load_vehicle("bluerov2-heavy").with_fault(3)
    assert len(isolation(vehicle).shows) == 7
    last = load_vehicle("ukwial").with_fault(0).with_fault(1).with_fault(2)
    result = isolation(last)
    assert result.alike == result.trials == ()
