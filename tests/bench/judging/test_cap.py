"""The cost of a cap, and the power of demands: against arithmetic, and no way beats the largest share."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, alpha_max, build, load_vehicle
from alloc.vehicle.current import Cap
from bench.demands import DemandSet, labelled
from bench.judging.cap import (
    FEEDBACK,
    MIXED,
    TIME_CONSTANT,
    WITHIN,
    WITHOUT,
    cap_excesses,
    energy_lines,
    fuse_cost,
    limiter_thrusts,
    mean_power,
    output_factor,
)

AMPS, VOLTS, DT = 20.0, 12.0, 0.01


@cache
def heavy(amps: float = AMPS) -> Vehicle:
    return replace(load_vehicle("bluerov2-heavy"), cap=Cap(amps, 0.0, False, VOLTS))


def test_the_cost_is_that_of_the_file_s_cap_and_a_cap_that_never_binds_costs_nothing_but_apart(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("bench.judging.cap.DIRECTIONS", 8)
    monkeypatch.setattr("bench.judging.cap.MISSIONS", ())
    monkeypatch.setattr("bench.judging.cap.cap_excesses", lambda *_: [])
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


@pytest.mark.parametrize(
    ("amps", "before", "r"),
    [
        (20.0, 20.0, 1.0),  # at the cap it stays
        (15.0, 15.0, 0.75),
        (28.0, 28.0, 1.4),
        (40.0, 40.0, 2.5),
        (18.0, 17.0, 23.0 / 20.0),  # below the cap, and above it in five loops
        (22.0, 21.0, 1.1),  # above already: the current itself
        (22.0, VOLTS, 2.5),  # beyond one and a half times the cap in five loops
    ],
)
def test_the_factor_follows_the_current_of_now_or_of_five_loops_on(
    amps: float, before: float, r: float
) -> None:
    assert output_factor(0.5, amps, before, 20.0, DT) == pytest.approx(
        0.5 + DT / (DT + TIME_CONSTANT) * (1.0 - r)
    )
    assert output_factor(1.0, 0.0, 0.0, 20.0, DT) == 1.0
    assert output_factor(0.0, 90.0, 90.0, 20.0, DT) == 0.0


def test_the_limiter_lets_the_first_current_through_and_ends_at_the_cap() -> None:
    f = np.full((600, 8), 20.0)
    u = heavy().commands(f, VOLTS).u
    amps = heavy().draw(VOLTS).amps(limiter_thrusts(heavy(), u, np.full(600, 20.0), VOLTS, 0.1)).sum(axis=1)
    assert amps[0] == pytest.approx(heavy().draw(VOLTS).amps(f[0]).sum(), rel=0.01)
    assert amps[0] > 2 * 20.0
    assert amps[-1] == pytest.approx(20.0, rel=0.02)


def test_allocation_within_the_cap_never_exceeds_it_and_the_limiter_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def drawn(_: str, vehicle: Vehicle, seed: int) -> DemandSet:
        f = np.random.default_rng(seed).uniform(-25, 25, (200, vehicle.n))
        return labelled("mission", vehicle, f @ vehicle.T.T, rate_hz=100.0)

    monkeypatch.setattr("bench.judging.cap.build_demands", drawn)
    found = {each.way: each for each in cap_excesses(heavy(), 1)}
    F = build("scaled", heavy()).many(drawn("", heavy(), 1).taus, *heavy().esc_limits(VOLTS))[0]
    over = heavy().draw(VOLTS).amps(F).sum(axis=1) - heavy().cap.amps() * np.linspace(1.0, 0.6, 200)
    assert found[WITHOUT].over_A == pytest.approx(over.max(), abs=1e-3)  # of all, not of every tenth
    assert found[WITHIN].over_A == found[WITHIN].over_share == 0.0
    assert 0.0 < found[FEEDBACK].over_A <= found[WITHOUT].over_A
    assert found[FEEDBACK].over_share < found[WITHOUT].over_share
    assert found[WITHIN].share_p50 < 1.0
    assert found[WITHOUT].share_min == pytest.approx(1.0)
    assert found[MIXED].share_p50 < found[WITHIN].share_p50


def test_a_mixer_s_output_is_a_share_of_the_pulse_and_its_thrust_is_on_the_curve(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Half of input forward, 141.4 N: four outputs of a half, so 1300 and 1700 µs."""
    ahead = labelled("mission", heavy(), np.array([[141.42 / 2, 0, 0, 0, 0, 0]]), rate_hz=100.0)
    monkeypatch.setattr("bench.judging.cap.build_demands", lambda *_: ahead)
    seen = []
    monkeypatch.setattr("bench.judging.cap.limiter_thrusts", lambda _, u, *rest: seen.append(u) or 0.0 * u)
    cap_excesses(heavy(), 0)
    assert seen[-1][0] == pytest.approx([1300, 1300, 1700, 1700, 1500, 1500, 1500, 1500])


def test_a_mixer_that_pushes_by_the_curve_sends_the_pulses_that_its_thrusts_take(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mixer = heavy().autopilot
    assert mixer is not None
    vehicle = replace(heavy(), autopilot=replace(mixer, curve=True))
    ahead = labelled("mission", vehicle, np.array([[60.0, 0, 0, 0, 0, 0]]), rate_hz=100.0)
    monkeypatch.setattr("bench.judging.cap.build_demands", lambda *_: ahead)
    seen = []
    monkeypatch.setattr("bench.judging.cap.limiter_thrusts", lambda _, u, *rest: seen.append(u) or 0.0 * u)
    cap_excesses(vehicle, 0)
    np.testing.assert_allclose(
        vehicle.thrusts(seen[-1][0]), build("ardusub", vehicle)(ahead.taus[0]).f, atol=0.3
    )


def test_a_vehicle_without_a_cap_or_a_voltage_is_not_flown() -> None:
    assert cap_excesses(replace(heavy(), cap=None), 0) == []
    assert cap_excesses(replace(heavy(), cap=Cap(20.0)), 0) == []


TWO = """name: two
dof: [surge, yaw]
T: [[1, 1], [0.2, -0.2]]
esc:
  {neutral: 0, range: [-100, 100], volts: 10, curve: {10: [[-100, -30], [0, 0], [100, 30]]},
   current: {ahead: 0.1, astern: 0.2, power: 1.5}}
cap: {amps: 12}
"""


@pytest.fixture
def two(tmp_path: Path) -> Vehicle:
    (tmp_path / "two.yaml").write_text(TWO)
    return load_vehicle(tmp_path / "two.yaml")


def test_without_freedom_both_powers_are_the_law_s_weighted_by_time(two: Vehicle) -> None:
    # 8 N ahead each, then one 4 N ahead and one 4 N astern.
    demands = labelled("by hand", two, np.array([[16.0, 0.0], [0.0, 1.6]]))
    power = mean_power(demands, 10.0, np.array([3.0, 1.0]))
    assert power is not None
    by_hand = 10.0 * (3 * 2 * 0.1 * 8**1.5 + (0.1 + 0.2) * 4**1.5) / 4
    assert power.effort_W == pytest.approx(by_hand, rel=1e-5)
    assert power.least_W == pytest.approx(by_hand, rel=1e-5)
    assert (power.n, power.seconds) == (2, 4.0)
    assert power.words == f"{by_hand * 4 / 3600:.3g} Wh by least effort, {by_hand * 4 / 3600:.3g} Wh" + (
        " at least current: 0 % less"
    )


def test_with_freedom_least_current_never_takes_more_than_least_effort() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    thrusts = np.random.default_rng(1).uniform(-15, 15, (12, vehicle.n))
    power = mean_power(labelled("drawn", vehicle, thrusts @ vehicle.T.T), 12.0, np.ones(12))
    assert power is not None
    assert 0.8 * power.effort_W < power.least_W < power.effort_W


def test_a_line_needs_a_cap_a_voltage_and_times(two: Vehicle) -> None:
    taus, seconds = np.array([[16.0, 0.0]]), np.array([60.0])
    ((what, said),) = energy_lines(labelled("log", two, taus), seconds)
    assert what == "energy at 10 V"
    assert said.startswith("0.754 Wh by least effort")
    assert said.endswith(", by 1 of 1 demands")
    assert energy_lines(labelled("log", two, taus), None) == []
    without = replace(two, cap=None), replace(two, cap=Cap(12.0))
    assert [energy_lines(labelled("log", each, taus), seconds) for each in without] == [[], []]


def test_no_demand_that_draws_nothing_has_a_power(two: Vehicle) -> None:
    assert mean_power(labelled("none", two, np.zeros((3, 2))), 10.0, np.ones(3)) is None
