"""Promises of every method on a vehicle of each structure, whole and with a thruster off."""

from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from alloc import Allocator, NotApplicable, Status, Vehicle, build, catalogue, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE
from alloc.discovery import Entry
from alloc.errors import DemandError
from alloc.formulations import Family, find_formulation
from bench.demands.generated import edge_demands, numbered
from bench.gate import contract
from tests.not_asked import not_asked

N_DEMANDS = 12


def prepared(entry: Entry, vehicle: Vehicle) -> Allocator:
    if slow_to_compile(entry, vehicle):
        not_asked("each vehicle takes a second to compile; tests/alloc/rivals asks others")
    try:
        return build(entry.name, vehicle)
    except NotApplicable as reason:
        not_asked(f"{entry.name} refuses {vehicle.name}: {reason}")


def slow_to_compile(entry: Entry, vehicle: Vehicle) -> bool:
    """True for a solver's C of another vehicle than the smallest or another fault than the first."""
    chosen = vehicle.name == "ukwial" and vehicle.readiness[1:].min() == 1
    return entry.family is Family.GENERATED and not chosen


def demands(vehicle: Vehicle, rng: np.random.Generator, size: float) -> np.ndarray:
    """Wrenches of thrusts that are ``size`` times a random thrust inside the limits."""
    thrusts = rng.uniform(vehicle.f_min, vehicle.f_max, (N_DEMANDS, vehicle.n))
    wrenches: np.ndarray = size * thrusts @ vehicle.TP.T
    return wrenches


def inside(f: np.ndarray, vehicle: Vehicle) -> bool:
    return bool((f >= vehicle.f_min).all() and (f <= vehicle.f_max).all())


@pytest.fixture(params=[None, 0], ids=["whole", "thruster 0 off"])
def case(request: pytest.FixtureRequest, vehicle: Vehicle) -> Vehicle:
    return vehicle if request.param is None else vehicle.with_fault(request.param % vehicle.n)


@pytest.fixture(scope="module")
def small() -> Vehicle:
    """The smallest vehicle: how a demand is read, checked and left alone is the same code for all of them."""
    return load_vehicle("ukwial")


def test_every_answer_is_what_its_status_says(entry: Entry, case: Vehicle, rng: np.random.Generator) -> None:
    says_what_it_makes(
        prepared(entry, case), case, np.vstack([demands(case, rng, size) for size in (0.3, 1.0, 3.0)])
    )


@pytest.mark.parametrize("number", [2, 12])
def test_every_answer_is_what_its_status_says_where_printed_digits_decide(entry: Entry, number: int) -> None:
    """Vehicles symmetric but for their last digits, asked for their edges; the first does not reverse."""
    vehicle, rng = numbered(number)
    says_what_it_makes(prepared(entry, vehicle), vehicle, edge_demands(vehicle, rng, 3 * N_DEMANDS))


def says_what_it_makes(allocate: Allocator, case: Vehicle, taus: np.ndarray) -> None:
    """Each answer lies inside the limits, and makes what status and share say."""
    way = find_formulation(allocate.formulation).way
    for tau in taus:
        f, status, _, _, share, *_ = allocate(tau)
        assert f.shape == (case.n,)
        assert f.dtype == np.float64
        if status in (Status.INFEASIBLE, Status.NOT_CONVERGED):
            assert np.isnan(f).all()
            continue
        assert np.isfinite(f).all()
        assert (f[case.readiness == 0] == 0.0).all()
        assert inside(f, case) or not allocate.limited
        if status is Status.SOLVED and not find_formulation(allocate.formulation).gives_way:
            error = np.abs(case.TP @ f - tau) / case.wrench_scale
            assert error.max() <= WRENCH_TOLERANCE
        if way is not None and share:
            on = way(case)
            begin = on.departure(case.f_min, case.f_max)
            says = on.delivered(tau[None], begin, np.array([share]))[0]
            error = np.abs(case.TP @ f - says) / case.wrench_scale
            assert error.max() <= WRENCH_TOLERANCE


def test_a_demand_that_can_be_met_is_never_called_infeasible(
    entry: Entry, case: Vehicle, rng: np.random.Generator
) -> None:
    allocate = prepared(entry, case)
    statuses = {allocate(tau).status for tau in demands(case, rng, 0.9)}
    assert Status.INFEASIBLE not in statuses


def test_the_demand_is_left_alone_and_each_answer_is_a_fresh_array(
    entry: Entry, small: Vehicle, rng: np.random.Generator
) -> None:
    allocate = prepared(entry, small)
    first, second = demands(small, rng, 0.3)[:2]
    before = first.copy()
    f = allocate(first).f
    kept = f.copy()
    other = allocate(second).f
    assert (first == before).all()
    assert not np.shares_memory(f, other)
    assert not np.shares_memory(f, first)
    np.testing.assert_array_equal(f, kept)
    f[:] = 0.0  # a caller may write into its answer
    assert not np.array_equal(allocate(second).f, np.zeros(small.n))


def test_the_same_demand_gets_the_same_answer_again(
    entry: Entry, vehicle: Vehicle, rng: np.random.Generator
) -> None:
    allocate = prepared(entry, vehicle)
    tau, other = demands(vehicle, rng, 0.3)[:2]
    f = allocate(tau).f
    allocate(other)
    again = allocate(tau).f
    if np.isfinite(f).all() and np.isfinite(again).all():
        # A reused solver may start from its last state, which moves the answer only within its promise.
        assert np.abs(f - again).max() <= 2 * allocate.tolerance * vehicle.f_scale


def test_many_gives_the_answers_of_single_calls(
    entry: Entry, case: Vehicle, rng: np.random.Generator
) -> None:
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


@pytest.mark.parametrize("case", [-1], indirect=True, ids=["last thruster off"])
def test_a_thruster_that_is_off_gets_no_thrust(entry: Entry, case: Vehicle, rng: np.random.Generator) -> None:
    """The last one; the first is off above, and self-tests of C try all."""
    allocate = prepared(entry, case)
    for tau in demands(case, rng, 0.5)[:3]:
        f = allocate(tau).f
        assert np.isnan(f).all() or f[-1] == 0.0


@pytest.mark.parametrize("method", [each.name for each in catalogue() if not each.foreign])
def test_whatever_thruster_is_off_a_method_in_python_gives_it_no_thrust(
    method: str, vehicle: Vehicle, rng: np.random.Generator
) -> None:
    for thruster in range(vehicle.n):
        degraded = vehicle.with_fault(thruster)
        try:
            allocate = build(method, degraded)
        except NotApplicable:
            continue
        for tau in demands(degraded, rng, 0.5)[:3]:
            f = allocate(tau).f
            assert np.isnan(f).all() or f[thruster] == 0.0


def test_every_form_of_a_call_has_the_usual_answer(
    entry: Entry, small: Vehicle, rng: np.random.Generator
) -> None:
    """The table that the gate asks of plug-ins too: lists, strided arrays, limits by name, ``many``."""
    allocate = prepared(entry, small)
    taus = demands(small, rng, 0.3)[:5]
    low, high = (np.tile(side / 2, (len(taus), 1)) for side in (small.f_min, small.f_max))
    answered = contract.forms(allocate, taus, low, high)
    allowed = 2 * (allocate.tolerance if allocate.tolerance < 1.0 else 1e-9) * small.f_scale
    wrong = {form: held for form, held in answered.items() if not held.get("apart", np.inf) <= allowed}
    assert not wrong
    assert all(held["same"] for held in answered.values())
    assert len(answered) >= len(contract.CONVERSIONS) + 2


def test_nan_infinity_and_numbers_beyond_1e100_are_refused(entry: Entry, small: Vehicle) -> None:
    allocate = prepared(entry, small)
    for axis, bad in product(range(small.k), [np.nan, np.inf, -np.inf, 1.1e100, -1.7e308]):
        tau = np.zeros(small.k)
        tau[axis] = bad
        with pytest.raises(DemandError, match="tau holds NaN, infinity or a number beyond 1e\\+100"):
            allocate(tau)
        with pytest.raises(DemandError, match="row 1"):
            allocate.many(np.vstack([np.zeros(small.k), tau]))


def test_no_method_with_limits_solves_a_demand_of_1e60(entry: Entry, vehicle: Vehicle) -> None:
    allocate = prepared(entry, vehicle)
    f, status, *_ = allocate(1e60 * np.resize([1.0, -1.0], vehicle.k))
    if allocate.limited:
        assert status is not Status.SOLVED
    assert np.isnan(f).all() if status in (Status.INFEASIBLE, Status.NOT_CONVERGED) else np.isfinite(f).all()
    assert inside(f, vehicle) or np.isnan(f).all() or not allocate.limited


def test_a_demand_of_the_wrong_shape_is_refused(entry: Entry, small: Vehicle) -> None:
    allocate = prepared(entry, small)
    for tau in (np.zeros(small.k + 1), np.zeros((small.k, 1)), 0.0, [], "fast", [[0.0], 1.0]):
        with pytest.raises(DemandError):
            allocate(tau)
    with pytest.raises(ValueError, match="shape"):  # DemandError is a ValueError too
        allocate.many(np.zeros(small.k))


def test_a_zero_demand_is_solved_with_zero_thrust(entry: Entry, vehicle: Vehicle) -> None:
    allocate = prepared(entry, vehicle)
    f, status, *_ = allocate(np.zeros(vehicle.k))
    if entry.name == "qp/qoco@generated" and status is Status.NOT_CONVERGED:
        pytest.xfail("QOCO's C gives up on it: docs/rivals.md")
    assert status is Status.SOLVED
    assert np.abs(f).max() <= allocate.tolerance * vehicle.f_scale


def test_an_integer_too_large_for_a_float_is_refused(entry: Entry, small: Vehicle) -> None:
    allocate = prepared(entry, small)
    tau = [10**400] + [0] * (small.k - 1)
    with pytest.raises(DemandError, match="not an array of numbers"):
        allocate(tau)
    with pytest.raises(DemandError, match="not an array of numbers"):
        allocate.many([tau])


def test_complex_numbers_text_and_dates_are_refused(entry: Entry, small: Vehicle) -> None:
    """numpy would turn each of these into real numbers."""
    allocate = prepared(entry, small)
    text, dates = np.array(["1"], dtype=object), np.array([1], dtype="M8[s]")
    for entries in (np.array([1.0 + 2.0j]), np.array([1.0 + 0.0j]), ["1"], [b"1"], text, dates):
        tau = np.resize(entries, small.k)
        with pytest.raises(DemandError, match="tau is not an array of numbers"):
            allocate(tau)
        with pytest.raises(DemandError, match="taus is not an array of numbers"):
            allocate.many([tau, tau])


@pytest.mark.parametrize(
    "number", [np.float32(2), np.int8(2), 2, True, Fraction(2)], ids=lambda x: type(x).__name__
)
def test_a_demand_may_hold_any_kind_of_real_number(small: Vehicle, number: Any) -> None:
    allocate = build("pinv", small)
    tau = np.resize(np.array([number]), small.k)
    np.testing.assert_array_equal(allocate(tau).f, allocate([float(number)] * small.k).f)
