"""Power of demands by least effort and at least current: by hand where nothing is free, else never more."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.vehicle.current import Cap
from bench.demands import labelled
from bench.judging.energy import energy_lines, mean_power

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
    assert energy_lines(labelled("log", two, taus), None) == []
    without = replace(two, cap=None), replace(two, cap=Cap(12.0))
    assert [energy_lines(labelled("log", each, taus), seconds) for each in without] == [[], []]


def test_no_demand_that_draws_nothing_has_a_power(two: Vehicle) -> None:
    assert mean_power(labelled("none", two, np.zeros((3, 2))), 10.0, np.ones(3)) is None
