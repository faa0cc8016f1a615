"""What every method of the catalogue promises, on every vehicle, whole and with a thruster off."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from alloc import (
    WRENCH_TOLERANCE,
    Allocator,
    DemandError,
    Entry,
    NotApplicable,
    Status,
    Vehicle,
    build,
    load_vehicle,
)

N_DEMANDS = 12


def prepared(entry: Entry, vehicle: Vehicle) -> Allocator:
    try:
        return build(entry.name, vehicle)
    except NotApplicable as reason:
        pytest.skip(f"{entry.name} refuses {vehicle.name}: {reason}")


def demands(vehicle: Vehicle, rng: np.random.Generator, size: float) -> np.ndarray:
    """Wrenches of thrusts that are ``size`` times a random thrust inside the limits."""
    thrusts = rng.uniform(vehicle.f_min, vehicle.f_max, (N_DEMANDS, vehicle.n))
    wrenches: np.ndarray = size * thrusts @ vehicle.TP.T
    return wrenches


def inside(f: np.ndarray, vehicle: Vehicle) -> bool:
    return bool((f >= vehicle.f_min).all() and (f <= vehicle.f_max).all())


@pytest.fixture(params=[None, 0], ids=["whole", "thruster 0 off"])
def case(request: pytest.FixtureRequest, vehicle: Vehicle) -> Vehicle:
    return vehicle if request.param is None else vehicle.with_fault(request.param)


@pytest.mark.parametrize("size", [0.3, 1.0, 3.0], ids=["small", "full", "beyond"])
def test_every_answer_is_what_its_status_says(
    entry: Entry, case: Vehicle, size: float, rng: np.random.Generator
) -> None:
    allocate = prepared(entry, case)
    for tau in demands(case, rng, size):
        f, status, _, _ = allocate(tau)
        assert f.shape == (case.n,)
        assert f.dtype == np.float64
        if status in (Status.INFEASIBLE, Status.NOT_CONVERGED):
            assert np.isnan(f).all()
            continue
        assert np.isfinite(f).all()
        assert inside(f, case) or not allocate.limited
        if status is Status.SOLVED and allocate.formulation != "soft":
            error = np.abs(case.TP @ f - tau) / case.wrench_scale
            assert error.max() <= WRENCH_TOLERANCE


def test_a_demand_that_can_be_met_is_never_called_infeasible(
    entry: Entry, case: Vehicle, rng: np.random.Generator
) -> None:
    allocate = prepared(entry, case)
    statuses = {allocate(tau).status for tau in demands(case, rng, 0.9)}
    assert Status.INFEASIBLE not in statuses


def test_the_input_is_left_alone_and_the_output_is_nobody_elses(
    entry: Entry, vehicle: Vehicle, rng: np.random.Generator
) -> None:
    allocate = prepared(entry, vehicle)
    first, second = demands(vehicle, rng, 0.3)[:2]
    before = first.copy()
    f = allocate(first).f
    kept = f.copy()
    other = allocate(second).f
    assert (first == before).all()
    assert not np.shares_memory(f, other)
    assert not np.shares_memory(f, first)
    np.testing.assert_array_equal(f, kept)
    f[:] = 0.0  # a caller may write into its answer
    assert not np.array_equal(allocate(second).f, np.zeros(vehicle.n))


def test_the_same_demand_gets_the_same_answer_again(
    entry: Entry, vehicle: Vehicle, rng: np.random.Generator
) -> None:
    allocate = prepared(entry, vehicle)
    one, other = demands(vehicle, rng, 0.3)[:2]
    f = allocate(one).f
    allocate(other)
    again = allocate(one).f
    if np.isfinite(f).all() and np.isfinite(again).all():
        # A reused solver may start from where it stood; the answer moves within its own promise only.
        assert np.abs(f - again).max() <= 2 * allocate.tolerance * vehicle.f_scale


def test_many_answers_as_one_by_one(entry: Entry, case: Vehicle, rng: np.random.Generator) -> None:
    allocate = prepared(entry, case)
    taus = np.vstack([demands(case, rng, 0.3)[:4], demands(case, rng, 3.0)[:4]])
    F, statuses = allocate.many(taus)
    assert F.shape == (8, case.n)
    assert statuses.shape == (8,)
    fresh = build(entry.name, case)
    for tau, f, status in zip(taus, F, statuses, strict=True):
        single = fresh(tau)
        assert single.status == status
        np.testing.assert_allclose(f, single.f, rtol=0, atol=2 * allocate.tolerance * case.f_scale)


def test_a_thruster_that_is_off_gives_nothing(
    entry: Entry, vehicle: Vehicle, rng: np.random.Generator
) -> None:
    for thruster in range(vehicle.n):
        degraded = vehicle.with_fault(thruster)
        try:
            allocate = build(entry.name, degraded)
        except NotApplicable:
            continue
        for tau in demands(degraded, rng, 0.5)[:3]:
            f = allocate(tau).f
            assert np.isnan(f).all() or f[thruster] == 0.0


def test_a_list_of_numbers_is_a_demand_too(entry: Entry, vehicle: Vehicle, rng: np.random.Generator) -> None:
    allocate = prepared(entry, vehicle)
    tau = demands(vehicle, rng, 0.3)[0]
    listed = allocate(tau.tolist())
    assert (
        np.abs(listed.f - allocate(tau).f).max() <= 2 * allocate.tolerance * vehicle.f_scale
        or np.isnan(listed.f).all()
    )
    strided = np.repeat(tau, 2)[::2]
    assert not strided.flags.c_contiguous or len(tau) == 1
    assert allocate(strided).f.shape == (vehicle.n,)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1.1e100, -1.7e308], ids=str)
def test_a_demand_that_is_no_wrench_is_refused(entry: Entry, vehicle: Vehicle, bad: float) -> None:
    allocate = prepared(entry, vehicle)
    for axis in range(vehicle.k):
        tau = np.zeros(vehicle.k)
        tau[axis] = bad
        with pytest.raises(DemandError, match="tau holds NaN, infinity or a number beyond 1e\\+100"):
            allocate(tau)
        with pytest.raises(DemandError, match="row 1"):
            allocate.many(np.vstack([np.zeros(vehicle.k), tau]))


def test_a_demand_beyond_everything_is_solved_by_no_method_with_limits(
    entry: Entry, vehicle: Vehicle
) -> None:
    allocate = prepared(entry, vehicle)
    f, status, _, _ = allocate(1e60 * np.resize([1.0, -1.0], vehicle.k))
    if allocate.limited:
        assert status is not Status.SOLVED
    assert np.isnan(f).all() if status in (Status.INFEASIBLE, Status.NOT_CONVERGED) else np.isfinite(f).all()
    assert inside(f, vehicle) or np.isnan(f).all() or not allocate.limited


def test_a_demand_of_the_wrong_shape_is_refused(entry: Entry, vehicle: Vehicle) -> None:
    allocate = prepared(entry, vehicle)
    for tau in (np.zeros(vehicle.k + 1), np.zeros((vehicle.k, 1)), 0.0, [], "fast", [[0.0], 1.0]):
        with pytest.raises(DemandError):
            allocate(tau)  # wrong types are the point
    with pytest.raises(ValueError, match="shape"):  # DemandError is one: callers need not know our types
        allocate.many(np.zeros(vehicle.k))


def test_zero_asks_for_nothing(entry: Entry, vehicle: Vehicle) -> None:
    allocate = prepared(entry, vehicle)
    f, status, _, _ = allocate(np.zeros(vehicle.k))
    assert status is Status.SOLVED
    assert np.abs(f).max() <= allocate.tolerance * vehicle.f_scale


def test_an_integer_beyond_every_float_is_refused(entry: Entry, vehicle: Vehicle) -> None:
    allocate = prepared(entry, vehicle)
    tau = [10**400] + [0] * (vehicle.k - 1)
    with pytest.raises(DemandError, match="not an array of numbers"):
        allocate(tau)
    with pytest.raises(DemandError, match="not an array of numbers"):
        allocate.many([tau])


@pytest.mark.parametrize(
    "method", ["clip", "shrink", "redistribute", "desaturate", "fixed-point", "nullspace", "scaled"]
)
@pytest.mark.parametrize("limit", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("size", [1e30, 1e100])
def test_the_largest_demand_gets_an_answer_inside_the_limits_or_none(
    method: str, limit: float, size: float
) -> None:
    T = np.array([[1.0, 1.0, 0.0, 0.3], [0.0, 0.5, 1.0, 0.2]])
    limits = np.full(4, limit)
    whole = Vehicle("made-up", ("surge", "sway"), T, np.eye(4), -limits, limits, np.ones(4), np.ones(2))
    for vehicle in (whole, whole.with_fault(0).with_fault(1).with_fault(3)):
        allocate = build(method, vehicle)
        tau = np.array([size, -size])
        one = allocate(tau)
        F, statuses = allocate.many([tau])
        assert one.status == statuses[0] == (Status.INFEASIBLE if method == "nullspace" else Status.PARTIAL)
        if method != "nullspace":
            assert inside(one.f, vehicle)
            assert inside(F[0], vehicle)


@pytest.mark.parametrize("method", ["clip", "redistribute", "nullspace", "scaled", "qp/daqp"])
def test_a_vehicle_made_with_a_thruster_off_is_the_one_that_lost_it(method: str) -> None:
    T, eye, readiness = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0]]), np.eye(3), np.array([0.0, 1.0, 1.0])
    low, high = np.array([10.0, -5.0, -5.0]), np.array([20.0, 5.0, 5.0])
    made = Vehicle("made", ("surge", "sway"), T, eye, low, high, readiness, np.ones(2))
    f, status, _, _ = build(method, made)([1.0, 1.0])
    assert status is Status.SOLVED
    assert f[0] == made.f_min[0] == made.f_max[0] == 0.0
    np.testing.assert_allclose(f, [0.0, 1.0, 0.0], rtol=0, atol=1e-8)


def test_what_numpy_would_turn_into_numbers_is_still_no_demand(entry: Entry) -> None:
    """Complex numbers, with and without an imaginary part; text in three disguises; dates."""
    vehicle = load_vehicle("ukwial")
    allocate = prepared(entry, vehicle)
    text, dates = np.array(["1"], dtype=object), np.array([1], dtype="M8[s]")
    for one in (np.array([1.0 + 2.0j]), np.array([1.0 + 0.0j]), ["1"], [b"1"], text, dates):
        tau = np.resize(one, vehicle.k)
        with pytest.raises(DemandError, match="tau is not an array of numbers"):
            allocate(tau)
        with pytest.raises(DemandError, match="taus is not an array of numbers"):
            allocate.many([tau, tau])


@pytest.mark.parametrize(
    "number", [np.float32(2), np.int8(2), 2, True, Fraction(2)], ids=lambda x: type(x).__name__
)
def test_every_kind_of_real_number_is_one(number: Any) -> None:
    vehicle = load_vehicle("ukwial")
    allocate = build("pinv", vehicle)
    tau = np.resize(np.array([number]), vehicle.k)
    np.testing.assert_array_equal(allocate(tau).f, allocate([float(number)] * vehicle.k).f)
