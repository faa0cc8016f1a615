"""Rules that keep a cap: each makes its share of the demand, within the cap, and none more than `frugal`."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from alloc import Status, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.methods.cap_by_thruster import limits_at_current

AMPS, VOLTS = 20.0, 12.0
HEAVY = load_vehicle("bluerov2-heavy")
SUPPLY = {"cap": AMPS, "volts": VOLTS}
RULES = ("cap-by-ratio", "cap-by-thruster")


def demands(count: int) -> Iterator[FloatArray]:
    """Demands that no cap lets through whole."""
    for f in np.random.default_rng(3).uniform(HEAVY.f_min, HEAVY.f_max, (count, HEAVY.n)):
        tau = HEAVY.T @ f
        yield 100.0 * tau / np.abs(tau / HEAVY.wrench_scale).max()


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_makes_its_share_of_the_demand_within_the_cap_and_no_more_than_the_largest(rule: str) -> None:
    limits, draw = HEAVY.esc_limits(VOLTS), HEAVY.draw(VOLTS)
    allocate, frugal = build(rule, HEAVY), build("frugal", HEAVY)
    for tau in demands(6):
        found, largest = allocate(tau, *limits, **SUPPLY), frugal(tau, *limits, **SUPPLY).share[0]
        assert HEAVY.T @ found.f == pytest.approx(found.share[0] * tau, abs=1e-6 * HEAVY.f_scale)
        np.testing.assert_array_equal(found.amps, draw.amps(found.f))
        assert np.sum(found.amps) <= AMPS * (1 + 1e-9)
        assert 0.0 < found.share[0] <= largest * (1 + 1e-9)


def test_one_ratio_uses_the_whole_cap_and_thrusters_apart_no_more_than_their_part_of_it() -> None:
    limits, one_off = HEAVY.esc_limits(VOLTS), HEAVY.with_fault(2)
    by_ratio, by_thruster = build("cap-by-ratio", HEAVY), build("cap-by-thruster", HEAVY)
    for tau in demands(6):
        assert np.sum(by_ratio(tau, *limits, **SUPPLY).amps) == pytest.approx(AMPS)
        assert max(by_thruster(tau, *limits, **SUPPLY).amps) <= AMPS / 8 * (1 + 1e-9)
        apart = build("cap-by-thruster", one_off)(tau, **SUPPLY).amps
        assert max(apart) == pytest.approx(AMPS / 7)


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_without_a_cap_answers_as_scaled_and_a_small_demand_is_solved_under_one(rule: str) -> None:
    allocate, scaled, tau = build(rule, HEAVY), build("scaled", HEAVY), np.full(6, 1.0)
    np.testing.assert_array_equal(allocate(tau).f, scaled(tau).f)
    found = allocate(tau, **SUPPLY)
    assert found.status == Status.SOLVED
    np.testing.assert_array_equal(found.f, scaled(tau).f)


def test_where_rest_is_excluded_a_rule_may_give_up_and_a_cap_below_rest_is_infeasible() -> None:
    forced = replace(HEAVY, f_min=np.full(8, 1.0))
    forced = replace(forced, f_min=np.r_[np.full(7, 1.0), 20.0])
    tau = forced.T @ np.full(8, 25.0)
    rest = forced.draw(VOLTS).amps(forced.f_min).sum()
    by_thruster, by_ratio = build("cap-by-thruster", forced), build("cap-by-ratio", forced)
    assert by_ratio(tau, cap=0.5 * rest, volts=VOLTS).status == Status.INFEASIBLE
    assert by_ratio(tau, cap=2.0 * rest, volts=VOLTS).status == Status.PARTIAL
    gave_up = by_thruster(tau, cap=1.6 * rest, volts=VOLTS)
    assert gave_up.status == Status.NOT_CONVERGED
    assert np.isnan(gave_up.f).all()


def test_limits_at_a_part_of_the_cap_draw_it_and_thrusters_that_draw_less_keep_their_own() -> None:
    draw = HEAVY.draw(VOLTS)
    low, high = limits_at_current(draw, HEAVY.esc_limits(VOLTS), 2.5)
    assert draw.amps(low) == pytest.approx(2.5)
    assert draw.amps(high) == pytest.approx(2.5)
    short = np.full(8, -1.0), np.full(8, 1.0)
    assert np.array_equal(limits_at_current(draw, short, 2.5), short)
