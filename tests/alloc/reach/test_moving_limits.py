"""alpha* and labels within limits of each demand, against linear programs and other vehicles."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import Label, Vehicle, alpha_max, label, load_vehicle
from alloc.errors import DemandError
from alloc.reach.attainable import alpha_max_lp, alpha_range

N = 60


def moving(vehicle: Vehicle, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """(N, n) limits: inside the vehicle's, some of zero width, some crossing, some that exclude zero."""
    ends = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, N, vehicle.n)), axis=0)
    low, high = ends
    still = rng.random((N, vehicle.n)) < 0.2
    high = np.where(still, low, high)
    crossing = rng.random(N) < 0.1
    low[crossing, 0], high[crossing, 0] = 1.0, -1.0
    return low, high


def test_alpha_is_the_linear_program_s_within_limits_of_any_kind(
    vehicle: Vehicle, rng: np.random.Generator
) -> None:
    low, high = moving(vehicle, rng)
    thrusts = rng.uniform(low, np.maximum(low, high)) * rng.choice([0.5, 1.0, 2.0], (N, 1))
    taus = thrusts @ vehicle.TP.T
    least, most = alpha_range(vehicle, taus, low, high)
    compared = 0
    for i, tau in enumerate(taus):
        if (low[i] > high[i]).any():
            assert (least[i], most[i]) == (np.inf, -np.inf)
            continue
        expected = alpha_max_lp(vehicle, tau, low[i], high[i]), -alpha_max_lp(vehicle, -tau, low[i], high[i])
        # HiGHS keeps bounds and equations within 1e-10 of their scale only.
        if np.isfinite(expected).all() and np.isfinite([most[i], least[i]]).all():
            assert (most[i], least[i]) == pytest.approx(expected, abs=1e-6, rel=1e-6)
            compared += 1
    assert compared > N / 3


def test_a_demand_of_thrusts_inside_its_limits_is_attainable_and_one_moved_out_is_not(
    vehicle: Vehicle, rng: np.random.Generator
) -> None:
    low, high = moving(vehicle, rng)
    possible = (low <= high).all(axis=1)
    taus = ((low + high) / 2) @ vehicle.TP.T
    least, most = alpha_range(vehicle, taus, low, high)
    assert (least[possible] <= 1 + 1e-9).all()
    assert (most[possible] >= 1 - 1e-9).all()
    direction = rng.normal(size=(N, vehicle.k)) / vehicle.wrench_scale
    farthest = np.where(direction @ vehicle.TP > 0, high, low)
    beyond = farthest @ vehicle.TP.T + 0.05 * direction * vehicle.wrench_scale**2
    labels = label(vehicle, beyond, f_min=low, f_max=high).label
    assert set(labels[possible]) <= {Label.INFEASIBLE, Label.BOUNDARY}
    assert set(labels[~possible]) <= {Label.INFEASIBLE}


def test_limits_of_a_demand_say_what_a_vehicle_with_these_limits_says(
    vehicle: Vehicle, rng: np.random.Generator
) -> None:
    low, high = vehicle.f_min * 0.7, vehicle.f_max * 0.4
    taus = rng.uniform(vehicle.f_min, vehicle.f_max, (N, vehicle.n)) @ vehicle.TP.T
    other = replace(vehicle, f_min=low, f_max=high)
    np.testing.assert_allclose(alpha_max(vehicle, taus, low, high), alpha_max(other, taus), rtol=1e-9)
    np.testing.assert_array_equal(label(vehicle, taus, f_min=low, f_max=high).label, label(other, taus).label)
    np.testing.assert_allclose(
        alpha_max(vehicle, taus, f_max=vehicle.f_max), alpha_max(vehicle, taus), rtol=1e-9
    )


def test_a_thruster_that_is_off_stays_off_whatever_limits_are_given() -> None:
    degraded = load_vehicle("ukwial").with_fault(1)
    tau = np.array([[300.0, 0.0, 0.0]])
    wide = np.full(4, 250.0)
    np.testing.assert_allclose(alpha_max(degraded, tau, -wide, wide), alpha_max(degraded, tau), rtol=1e-9)


@pytest.mark.parametrize(
    ("f_min", "says"),
    [
        (np.zeros(3), r"f_min has shape \(3,\); this vehicle takes \(4,\), or \(2, 4\)"),
        (np.zeros((3, 4)), "f_min has shape"),
        ([0, 0, 0, np.nan], "NaN, infinity"),
        (["a"] * 4, "not an array of numbers"),
    ],
)
def test_limits_that_are_none_are_refused(f_min: object, says: str) -> None:
    with pytest.raises(DemandError, match=says):
        alpha_max(load_vehicle("ukwial"), np.zeros((2, 3)), f_min)  # type: ignore[arg-type] - what is tested
