"""A cap that sags: allocation never exceeds it, a limiter that feeds the current back does at first."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.vehicle.current import Cap
from bench.demands import DemandSet, labelled
from bench.judging.sagging_cap import FEEDBACK, MIXED, WITHIN, WITHOUT, cap_excesses, fed_back, output_factor

DT, TC = 0.01, 5.0
LOOP = DT / (DT + TC)
VEHICLE = replace(load_vehicle("bluerov2-heavy"), cap=Cap(20.0, volts=12.0))


@pytest.mark.parametrize(
    ("amps", "before", "r"),
    [
        (20.0, 20.0, 1.0),  # at the cap it stays
        (15.0, 15.0, 0.75),
        (28.0, 28.0, 1.4),
        (40.0, 40.0, 2.5),
        (18.0, 17.0, 23.0 / 20.0),  # below the cap, and above it in five loops
        (22.0, 21.0, 1.1),  # above already: the current itself
        (22.0, 12.0, 2.5),  # beyond one and a half times the cap in five loops
    ],
)
def test_the_factor_follows_the_current_of_now_or_of_five_loops_on(
    amps: float, before: float, r: float
) -> None:
    assert output_factor(0.5, amps, before, 20.0, DT) == pytest.approx(0.5 + LOOP * (1.0 - r))
    assert output_factor(1.0, 0.0, 0.0, 20.0, DT) == 1.0
    assert output_factor(0.0, 90.0, 90.0, 20.0, DT) == 0.0


def test_the_limiter_lets_the_first_current_through_and_ends_at_the_cap() -> None:
    f = np.full((600, 8), 20.0)
    u = VEHICLE.commands(f, 12.0).u
    amps = VEHICLE.draw(12.0).amps(fed_back(VEHICLE, u, np.full(600, 20.0), 12.0, 0.1)).sum(axis=1)
    assert amps[0] == pytest.approx(VEHICLE.draw(12.0).amps(f[0]).sum(), rel=0.01)
    assert amps[0] > 2 * 20.0
    assert amps[-1] == pytest.approx(20.0, rel=0.02)


def test_allocation_within_the_cap_never_exceeds_it_and_the_limiter_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def drawn(_: str, vehicle: Vehicle, seed: int) -> DemandSet:
        f = np.random.default_rng(seed).uniform(-25, 25, (200, vehicle.n))
        return labelled("mission", vehicle, f @ vehicle.T.T, rate_hz=100.0)

    monkeypatch.setattr("bench.judging.sagging_cap.build_demands", drawn)
    found = {each.way: each for each in cap_excesses(VEHICLE, 1)}
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
    ahead = labelled("mission", VEHICLE, np.array([[141.42 / 2, 0, 0, 0, 0, 0]]), rate_hz=100.0)
    monkeypatch.setattr("bench.judging.sagging_cap.build_demands", lambda *_: ahead)
    seen = []
    monkeypatch.setattr("bench.judging.sagging_cap.fed_back", lambda _, u, *rest: seen.append(u) or 0.0 * u)
    cap_excesses(VEHICLE, 0)
    assert seen[-1][0] == pytest.approx([1300, 1300, 1700, 1700, 1500, 1500, 1500, 1500])


def test_a_vehicle_without_a_cap_or_a_voltage_is_not_flown() -> None:
    assert cap_excesses(replace(VEHICLE, cap=None), 0) == []
    assert cap_excesses(replace(VEHICLE, cap=Cap(20.0)), 0) == []
