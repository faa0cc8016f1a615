"""Worst of a method over demands, and what a sample says of others."""

import numpy as np
import pytest

from alloc import build, load_vehicle
from alloc.reach.volumes import uniform_demands
from bench.judging.loss import relative_wrench_error
from bench.judging.worst import expected_count, worst_loss
from bench.record import MISSED_MUCH


def test_an_exponential_tail_is_found_again() -> None:
    # 2000 exp(-edge) of these lie beyond an edge.
    values = -np.log((np.arange(2000) + 0.5) / 2000)
    for edge in (8.0, 10.0):
        assert expected_count(values, edge) == pytest.approx(2000 * np.exp(-edge), rel=0.25)


def test_many_numbers_beyond_an_edge_are_counted_and_a_sharp_end_is_none() -> None:
    assert expected_count(np.array([1.0] * 12 + [0.0] * 100), 1.0) == 12
    assert expected_count(np.full(100, 0.9), 1.0) == 0.0
    assert expected_count(np.array([0.5, 1.5]), 1.0) == 1.0  # too few for a tail


def test_other_demands_show_as_many_as_a_sample_lets_expect() -> None:
    # These end sharply, as losses do: no fewer are expected than seen, and not thrice as many.
    rng = np.random.default_rng(5)
    draws = 1.2 * rng.beta(2, 12, (1000, 2, 2000)) ** 0.5
    expected = np.mean([expected_count(first, 0.95) for first, _ in draws])
    found = np.mean(np.sum(draws[:, 1] >= 0.95, axis=1))
    assert found <= expected <= 3 * found


def test_demands_missed_by_a_quarter_are_counted_by_the_equation_of_loss() -> None:
    vehicle = load_vehicle("supply-vessel")
    taus = uniform_demands(vehicle, np.random.default_rng(3), 500)
    F = build("pinv", vehicle).many(taus)[0]
    missed = relative_wrench_error(vehicle, taus, F)
    loss = worst_loss(vehicle, taus, F)
    assert loss.missed_much == np.sum(missed >= MISSED_MUCH) > 0
    assert loss.missed_max == pytest.approx(missed.max(), rel=1e-5)
