"""Loss of small thrusts by curves, dead bands and steps, by arithmetic that needs no curve at all."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from bench.judging import last_metre
from bench.record import LastMetre

FINE = 0.01
"""A step [µs] that no wire resolves."""


@pytest.fixture(scope="module")
def heavy() -> dict[str, LastMetre]:
    vehicle = load_vehicle("bluerov2-heavy")
    return {each.way: each for each in last_metre.last_metre(vehicle, seed=3)}


def linear_vehicle(tmp_path: Path) -> Vehicle:
    """Three thrusters whose thrust is linear in the command, a newton a step."""
    (tmp_path / "line.yaml").write_text(
        "name: line\ndof: [surge, yaw]\nT: [[1, 1, 1], [0.5, -0.5, 0]]\nf_min: -40\nf_max: 40\n"
        "esc: {neutral: 0, range: [-40, 40]}\n"
    )
    return load_vehicle(tmp_path / "line.yaml")


def test_a_linear_map_is_right_where_thrust_is_linear(tmp_path: Path) -> None:
    vehicle = linear_vehicle(tmp_path)
    F = np.random.default_rng(0).uniform(-50, 50, (40, 3))
    assert (last_metre.linear_commands(vehicle, F) == np.rint(F.clip(-40, 40))).all()


def test_truncating_never_makes_more_than_was_asked_and_less_than_a_step_less(tmp_path: Path) -> None:
    vehicle = linear_vehicle(tmp_path)
    F = np.random.default_rng(0).uniform(-39, 39, (40, 3))
    ends = np.full((2, *F.shape), 40.0) * np.array([-1, 1])[:, None, None]
    assert (last_metre.truncated_commands(vehicle, F, *ends) == np.trunc(F)).all()


def test_steps_explain_the_error_of_a_rounded_linear_curve(tmp_path: Path) -> None:
    """Root of the mean of squares, which is what the formula is of: 500 demands tell it to a few percent."""
    vehicle = linear_vehicle(tmp_path)
    F = np.random.default_rng(0).uniform(-39, 39, (500, 3))
    taus = F @ vehicle.TP.T
    miss = (vehicle.commands(F).f - F) @ vehicle.TP.T / vehicle.wrench_scale
    size = np.linalg.norm(taus / vehicle.wrench_scale, axis=1)
    expected = last_metre.step_error(vehicle, taus, F) * size
    assert np.sqrt((miss**2).sum(axis=1).mean()) == pytest.approx(np.sqrt((expected**2).mean()), rel=0.1)


def test_a_linear_map_loses_a_t200_s_small_demands_and_its_curve_finds_them(heavy) -> None:
    linear, jumped = heavy["linear map"], heavy["curve, dead band jumped"]
    assert min(linear.error_p50) > 0.5
    assert max(jumped.error_p50) < 0.05
    assert linear.missed is not None
    assert jumped.missed is not None
    assert linear.missed > 10 * jumped.missed


def test_each_way_loses_no_less_than_the_next_better_one(heavy) -> None:
    truncated, stays, jumped = (list(heavy.values())[i] for i in (1, 2, 3))
    for share in range(len(last_metre.SHARES)):
        assert truncated.error_p50[share] > stays.error_p50[share] >= jumped.error_p50[share]
        # A median of 500 directions, beside a mean of squares: they agree to a tenth.
        assert jumped.error_p50[share] == pytest.approx(jumped.step_p50[share], rel=0.1)


def test_at_5_percent_of_authority_a_finer_wire_makes_the_wish_within_1_percent() -> None:
    """A step of 1 us alone explains 1.08 %; where steps are finer nothing else is lost."""
    vehicle = load_vehicle("bluerov2-heavy")
    fine = replace(vehicle, esc=tuple(replace(esc, step=FINE) for esc in vehicle.esc))
    rng = np.random.default_rng(1)
    F = rng.uniform(0.02, 0.05, (200, vehicle.n)) * rng.choice([-40.0, 40.0], (200, vehicle.n))
    miss = (fine.commands(F).f - F) @ vehicle.TP.T / vehicle.wrench_scale
    size = np.linalg.norm(F @ vehicle.TP.T / vehicle.wrench_scale, axis=1)
    assert (np.linalg.norm(miss, axis=1) / size < 0.01).all()


def test_a_vehicle_without_escs_has_no_last_metre() -> None:
    assert last_metre.last_metre(load_vehicle("ukwial"), seed=3) == []
