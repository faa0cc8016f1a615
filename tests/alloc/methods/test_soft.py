"""The active set for weighted least squares: its optimum in two other ways, its steps, and its C in float."""

import ctypes
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from alloc import NotApplicable, Status, Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.c import Target, missing, sources
from alloc.kernels import weighted
from alloc.methods import recipe
from alloc.methods.soft import MOST_THRUSTERS
from tests.compilers import build_program
from tests.nullspace_cases import random_vehicle
from tests.vehicles import made_up

SIZES = (0.5, 1.0, 2.0, 5.0, 30.0, 1e4)
"""Demands in units of what random thrusts inside the limits make."""


def demands(vehicle: Vehicle, rng: np.random.Generator, each: int = 8) -> FloatArray:
    """Wrenches of random thrusts, from inside the limits to far beyond (N, k)."""
    thrusts = rng.uniform(vehicle.f_min, vehicle.f_max, (len(SIZES) * each, vehicle.n))
    taus: FloatArray = np.repeat(SIZES, each)[:, None] * thrusts @ vehicle.TP.T
    return taus


def least_squares(
    vehicle: Vehicle, tau: FloatArray, low: FloatArray, high: FloatArray, wanted: FloatArray | float = 0.0
) -> FloatArray:
    """argmin |Q^1/2 (T P f - tau)|^2 + |H^1/2 (f - wanted)|^2 inside the limits, by SciPy's BVLS."""
    dear, cheap = np.sqrt(vehicle.slack_weights), np.sqrt(np.diag(vehicle.H))
    rows = np.vstack([dear[:, None] * vehicle.TP, np.diag(cheap)])
    right = np.concatenate([dear * tau, cheap * (wanted * np.ones(vehicle.n))])
    return np.asarray(lsq_linear(rows, right, (low, high), method="bvls", tol=1e-14).x)


@pytest.mark.parametrize("off", [None, 1])
@pytest.mark.parametrize("method", ["soft", "soft@native"])
def test_each_thrust_is_a_step_along_the_gradient_cut_at_its_limits(
    method: str, off: int | None, vehicle: Vehicle, rng: np.random.Generator
) -> None:
    """f = clip(f - g / diag M), g = H f + T'Q (T f - tau), holds of the optimum alone, and needs no table."""
    if missing() and "native" in method:
        pytest.skip(missing())
    case = vehicle if off is None else vehicle.with_fault(off)
    allocate = build(method, case)
    M = case.H + case.TP.T @ (case.slack_weights[:, None] * case.TP)
    taus = demands(case, rng)
    for tau, size in zip(taus, np.repeat(SIZES, len(taus) // len(SIZES)), strict=True):
        f = allocate(tau).f
        gradient = case.H @ f + case.TP.T @ (case.slack_weights * (case.TP @ f - tau))
        step = np.clip(f - gradient / np.diag(M), case.f_min, case.f_max)
        # Sums of this test itself round by this share of the largest product.
        assert np.abs(step - f).max() <= 1e-12 * size * case.f_scale


@pytest.mark.parametrize("shape", [(1, 1), (2, 4), (3, 3), (3, 6), (4, 8), (3, 11), (6, 12)])
def test_thrusts_are_those_of_bounded_least_squares_whatever_t_and_weights(shape: tuple[int, int]) -> None:
    """Up to eight thrusters tables are made beforehand, for more at their first use."""
    rng = np.random.default_rng(5)
    for _ in range(3):
        made = random_vehicle(*shape, rng)
        vehicle = replace(made, slack_weights=10.0 ** rng.uniform(-1, 3, made.k))
        allocate = build("soft", vehicle)
        for tau in demands(vehicle, rng, 3)[:12]:
            low, high = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, vehicle.n)), axis=0)
            found = allocate(tau, low, high)
            assert found.status is Status.PARTIAL
            assert found.iterations <= allocate.worst_case_steps  # type: ignore[attr-defined]
            expected = least_squares(vehicle, tau, low, high)
            np.testing.assert_allclose(found.f, expected, rtol=0, atol=1e-8 * vehicle.f_scale)


def test_thrusts_that_are_preferred_are_asked_for_by_what_is_left_of_a_demand() -> None:
    """min |f - f_d|^2 + … is the problem of f - f_d, for tau - T P f_d within limits moved as far."""
    vehicle, rng = load_vehicle("bluerov2-heavy"), np.random.default_rng(3)
    allocate = build("soft", vehicle)
    for tau in demands(vehicle, rng, 4):
        wanted = rng.uniform(1.5 * vehicle.f_min, 1.5 * vehicle.f_max)
        left = tau - vehicle.TP @ wanted
        f = wanted + allocate(left, vehicle.f_min - wanted, vehicle.f_max - wanted).f
        expected = least_squares(vehicle, tau, vehicle.f_min, vehicle.f_max, wanted)
        np.testing.assert_allclose(f, expected, rtol=0, atol=1e-8 * vehicle.f_scale)


@pytest.mark.parametrize("name", list_vehicles())
def test_every_demand_has_an_answer_in_the_steps_that_a_call_may_take(
    name: str, rng: np.random.Generator
) -> None:
    """Limits of the call are among these; ``docs/studies/soft.py steps`` asks many more."""
    vehicle = load_vehicle(name)
    allocate = build("soft", vehicle)
    for tau in demands(vehicle, rng):
        low, high = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, vehicle.n)), axis=0)
        for limits in ((None, None), (low, high)):
            found = allocate(tau, *limits)
            assert found.found
            assert found.iterations <= allocate.worst_case_steps  # type: ignore[attr-defined]


def test_a_call_that_would_take_more_steps_has_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = load_vehicle("ukwial")
    monkeypatch.setattr("alloc.methods.soft.STEPS_PER_THRUSTER", 0)
    allocate = build("soft", vehicle)
    beyond = allocate(10.0 * vehicle.wrench_scale)
    assert beyond.status is Status.NOT_CONVERGED
    assert np.isnan(beyond.f).all()
    assert allocate(0.1 * vehicle.wrench_scale).found  # no limit is met


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
def test_c_that_would_take_more_steps_leaves_f_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    vehicle = load_vehicle("ukwial")
    monkeypatch.setattr(weighted, "STEPS_PER_THRUSTER", 0)
    target = Target(vehicle=replace(vehicle), method=recipe("soft"))
    solve = ctypes.CDLL(str(build_program(tmp_path, sources(target), "-fPIC", "-shared")))[target.name]
    for size, status in ((10.0, Status.NOT_CONVERGED), (0.1, Status.PARTIAL)):
        tau, f = size * vehicle.wrench_scale, np.full(vehicle.n, 7.0)
        assert solve(_address(tau), -1, _address(f)) == status
        assert (f == 7.0).all() == (status == Status.NOT_CONVERGED)


def _address(array: np.ndarray) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@pytest.mark.parametrize("name", ["tiburon", "supply-vessel"])
def test_single_precision_misses_the_optimum_by_rounding_alone(name: str, tmp_path: Path) -> None:
    """The vehicles whose aims are magnified most; it is a share ``doubt`` of the call's largest thrust."""
    vehicle, rng = load_vehicle(name), np.random.default_rng(9)
    target = Target(vehicle=vehicle, method=recipe("soft"), scalar="float", faults="all")
    solve = ctypes.CDLL(str(build_program(tmp_path, sources(target), "-O2", "-fPIC", "-shared")))[target.name]
    share = recipe("soft").doubt(vehicle, "float")
    assert share < 1e-4
    for fault in (-1, 0, vehicle.n - 1):
        case = vehicle if fault < 0 else vehicle.with_fault(fault)
        allocate = build("soft", case)
        for tau in demands(vehicle, rng, 40)[:200]:
            given, f = tau.astype(np.float32), np.full(vehicle.n, np.nan, np.float32)
            assert solve(_address(given), fault, _address(f)) in (Status.SOLVED, Status.PARTIAL)
            right = allocate(given.astype(np.float64)).f
            size = vehicle.f_scale * (1.0 + np.abs(tau / vehicle.wrench_scale).max())
            assert np.abs(f - right).max() <= 4.0 * share * size


def test_vehicles_that_a_table_cannot_hold_are_refused_with_the_reason() -> None:
    coupled = replace(load_vehicle("ukwial"), H=np.eye(4) + 0.3)
    with pytest.raises(NotApplicable, match="H couples thrusters"):
        build("soft", coupled)
    many = made_up(np.ones((1, MOST_THRUSTERS + 1)))
    with pytest.raises(NotApplicable, match="covers up to 62 thrusters"):
        build("soft", many)
    nine = made_up(np.random.default_rng(1).normal(size=(3, 9)))
    assert build("soft", nine)(np.ones(3)).found
    with pytest.raises(NotApplicable, match="for 8 thrusters at most, and there are 9"):
        recipe("soft").program(nine)
