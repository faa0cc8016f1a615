"""The cost of a cap: each way keeps it, and none delivers more than the largest share there is."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from alloc import Vehicle, alpha_max, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.current import Cap
from bench.judging.fuse import EACH, LARGEST, RATIO, each_at, far, fuse_cost, ways

AMPS, VOLTS = 20.0, 12.0


@cache
def heavy(amps: float = AMPS) -> Vehicle:
    return replace(load_vehicle("bluerov2-heavy"), cap=Cap(amps, 0.0, False, VOLTS))


def demands(count: int) -> FloatArray:
    vehicle = heavy()
    thrusts = np.random.default_rng(3).uniform(vehicle.f_min, vehicle.f_max, (count, vehicle.n))
    return far(vehicle, thrusts @ vehicle.T.T)


def test_each_way_makes_its_share_of_the_demand_within_the_cap_and_none_more_than_the_largest() -> None:
    vehicle, limits = heavy(), heavy().esc_limits(VOLTS)
    answers, draw = ways(vehicle, limits, AMPS, VOLTS), vehicle.draw(VOLTS)
    for tau in demands(6):
        _, largest = answers[LARGEST](tau)
        for way in answers.values():
            f, share = way(tau)
            assert vehicle.T @ f == pytest.approx(share * tau, abs=1e-6 * vehicle.f_scale)
            assert draw.amps(f).sum() <= AMPS * (1 + 1e-9)
            assert 0.0 < share <= largest * (1 + 1e-9)


def test_one_ratio_uses_the_whole_cap_and_thrusters_apart_reach_no_farther_than_their_part_of_it() -> None:
    vehicle, limits = heavy(), heavy().esc_limits(VOLTS)
    answers, draw = ways(vehicle, limits, AMPS, VOLTS), vehicle.draw(VOLTS)
    for tau in demands(6):
        assert draw.amps(answers[RATIO](tau)[0]).sum() == pytest.approx(AMPS)
        assert draw.amps(answers[EACH](tau)[0]).max() <= AMPS / vehicle.n * (1 + 1e-9)


def test_limits_at_a_part_of_the_cap_draw_it_and_thrusters_that_draw_less_keep_their_own() -> None:
    draw = heavy().draw(VOLTS)
    low, high = each_at(draw, heavy().esc_limits(VOLTS), 2.5)
    assert draw.amps(low) == pytest.approx(2.5)
    assert draw.amps(high) == pytest.approx(2.5)
    short = np.full(8, -1.0), np.full(8, 1.0)
    assert np.array_equal(each_at(draw, short, 2.5), short)


def test_the_cost_is_that_of_the_file_s_cap_and_a_cap_that_never_binds_costs_nothing_but_apart(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("bench.judging.fuse.DIRECTIONS", 8)
    monkeypatch.setattr("bench.judging.energy.MISSIONS", ())
    monkeypatch.setattr("bench.judging.fuse.cap_excesses", lambda *_: [])
    cost, wide = fuse_cost(heavy(), 0), fuse_cost(heavy(1000.0), 0)
    assert cost is not None
    assert wide is not None
    assert (cost.amps, cost.volts, cost.n_demands) == (AMPS, VOLTS, 8)
    largest, path, ratio, each = cost.ways
    assert largest.share_min == largest.amps_max == 1.0
    assert each.share_p50 < ratio.share_p50 <= 1.0
    assert path.share_min <= path.share_p50 <= 1.0 <= path.amps_p50 <= path.amps_max
    limits = heavy().esc_limits(VOLTS)
    reach = [float(alpha_max(heavy(), axis[None], *limits)[0]) for axis in np.eye(6)]
    for way in wide.ways:
        assert way.share_min == pytest.approx(1.0)
        assert way.axis_max == pytest.approx(reach, rel=1e-5)


def test_a_vehicle_without_a_cap_or_whose_thrusters_can_not_rest_has_no_cost() -> None:
    assert fuse_cost(load_vehicle("bluerov2-heavy"), 0) is None
    assert fuse_cost(replace(heavy(), f_min=np.full(8, 5.0)), 0) is None
