"""``scaled``, ``scaled-by-group`` and ``priority`` answer always, deliver what they say, at least effort."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from alloc import Status, Vehicle, alpha_max, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.formulations import find_formulation
from alloc.reach.way import Way
from saturation import limits, vehicles
from tests.nullspace_cases import SHAPES, random_vehicle

METHODS = ("scaled", "scaled-by-group", "priority")
ROUNDING = 1e-9
"""Relative to the largest limit: rounding of products with a condition number below 1e3."""

methods = pytest.mark.parametrize("method", METHODS)


def way_of(method: str, vehicle: Vehicle) -> Way:
    way = find_formulation(method).way
    assert way is not None
    return way(vehicle)


def beyond(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """Demands (n, k) from a hundredth of what the vehicle can do to a hundred times that."""
    directions = rng.normal(size=(n, vehicle.k)) * vehicle.wrench_scale
    return directions * np.logspace(-2, 2, n)[rng.permutation(n), None]


def not_optimal(vehicle: Vehicle, f: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """Distance of f (n,) from the least effort for its own wrench, relative to the largest limit.

    Where H f = T'lambda + mu, with mu pushing thrusts only off limits that they touch, f is optimal (Karush,
    Kuhn, Tucker). What is left over, r, makes f the optimum of a cost that differs by r'f, H^-1 r away.
    """
    on = vehicle.working
    touch = 1e-9 * vehicle.f_scale
    columns = [*vehicle.TP[:, on], *-vehicle.TP[:, on]]
    for place, i in enumerate(on):
        unit = np.eye(len(on))[place]
        columns += [unit] if f[i] <= low[i] + touch else []
        columns += [-unit] if f[i] >= high[i] - touch else []
    H = vehicle.H[np.ix_(on, on)]
    weights = np.array(columns).T
    lengths = np.linalg.norm(weights, axis=0)
    weights = weights[:, lengths > 0] / lengths[lengths > 0]
    pushed = H @ f[on]
    multipliers, _ = nnls(weights, pushed)
    return float(np.abs(np.linalg.solve(H, pushed - weights @ multipliers)).max() / vehicle.f_scale)


@methods
def test_thrusts_lie_inside_the_limits_and_make_the_end_of_the_way_at_least_effort(
    method: str, rng: np.random.Generator
) -> None:
    for vehicle in vehicles():
        allocate, way = build(method, vehicle), way_of(method, vehicle)
        low, high = limits(vehicle, rng, 20)
        taus = beyond(vehicle, rng, 20)
        F, statuses = allocate.many(taus, low, high)
        assert (low <= F).all()
        assert (high >= F).all()
        ends, shares = way.towards_many(taus, way.departure(low, high))
        np.testing.assert_allclose((F @ vehicle.TP.T - ends) / vehicle.wrench_scale, 0.0, atol=ROUNDING)
        assert max(map(not_optimal, [vehicle] * 20, F, low, high)) <= ROUNDING, vehicle.name
        missed = np.abs((F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max(axis=1)
        np.testing.assert_array_equal(statuses == Status.SOLVED, (missed <= 1e-6) & (shares == 1).all(axis=1))


@methods
def test_a_single_call_gives_what_many_give_and_says_the_shares(
    method: str, rng: np.random.Generator
) -> None:
    for vehicle in vehicles():
        allocate, way = build(method, vehicle), way_of(method, vehicle)
        low, high = limits(vehicle, rng, 6)
        low[0], high[0] = vehicle.f_min, vehicle.f_max
        taus = beyond(vehicle, rng, 6)
        F, statuses = allocate.many(taus, low, high)
        _, shares = way.towards_many(taus, way.departure(low, high))
        for i, tau in enumerate(taus):
            one = allocate(tau, low[i], high[i])
            assert one.status == statuses[i]
            np.testing.assert_allclose(one.f, F[i], rtol=0, atol=ROUNDING * vehicle.f_scale)
            np.testing.assert_allclose(one.share, shares[i], rtol=1e-9)
        np.testing.assert_allclose(allocate(taus[0]).f, F[0], rtol=0, atol=ROUNDING * vehicle.f_scale)


@methods
def test_where_limits_contradict_themselves_there_is_no_answer(method: str, vehicle: Vehicle) -> None:
    allocate = build(method, vehicle)
    low = vehicle.f_min.copy()
    low[1] = vehicle.f_max[1] + 1e-9
    f, status, _, _, share, *_ = allocate(np.zeros(vehicle.k), f_min=low)
    F, statuses = allocate.many(np.zeros((2, vehicle.k)), f_min=np.array([low, vehicle.f_min]))
    assert status is Status.INFEASIBLE
    assert list(statuses) == [Status.INFEASIBLE, Status.SOLVED]
    assert np.isnan(f).all()
    assert np.isnan(F[0]).all()
    assert set(share) == {0.0}


SOME = [
    load_vehicle("bluerov2-heavy"),
    load_vehicle("supply-vessel").with_fault(1),
    load_vehicle("bluerov2").with_fault(5),
]
PREPARED = {(method, v.name): build(method, v) for method in METHODS for v in SOME}

size = st.sampled_from([0.0, 5e-324, 1e-310, 1e-200, 1e-12, 1.0, 40.0, 1e3, 1e30, 1e100])


@st.composite
def signed(draw: st.DrawFn, n: int) -> list[float]:
    return [draw(size) * draw(st.sampled_from([-1.0, 1.0, 0.37, -0.61])) for _ in range(n)]


@methods
@given(data=st.data())
def test_every_finite_demand_has_a_finite_answer_inside_any_limits(method: str, data: st.DataObject) -> None:
    vehicle = data.draw(st.sampled_from(SOME))
    a, b = np.array(data.draw(signed(vehicle.n))), np.array(data.draw(signed(vehicle.n)))
    low, high = np.minimum(a, b), np.maximum(a, b)
    tau = np.array(data.draw(signed(vehicle.k)))
    allocate = PREPARED[method, vehicle.name]
    f, status, _, _, share, *_ = allocate(tau, low, high)
    F, _ = allocate.many(tau[None], low, high)
    off = vehicle.readiness == 0
    for thrusts in (f, F[0]):
        assert (np.where(off, 0.0, low) <= thrusts).all()
        assert (np.where(off, 0.0, high) >= thrusts).all()
    assert status in (Status.SOLVED, Status.PARTIAL)
    assert all(0.0 <= s <= 1.0 for s in share)


@methods
def test_the_answer_has_no_jump_between_demands_and_limits(method: str, rng: np.random.Generator) -> None:
    """The two most different of 33 points on a line between two questions are taken apart, and so on.

    A jump would stay however near its two sides come; a slope shrinks with them, to 32^-9 of the line. Limits
    have some width, since without any the attainable set is flat, and a step out of it leads nowhere.
    """
    for vehicle in [v for v in vehicles() if v.rank == v.k][::3]:
        allocate = build(method, vehicle)
        for _ in range(4):
            questions = []
            for _ in range(2):
                low = rng.uniform(-1.0, 0.6, vehicle.n) * vehicle.f_scale
                width = rng.uniform(0.3, 1.2, vehicle.n) * vehicle.f_scale
                questions.append([beyond(vehicle, rng, 1)[0], low, low + width])
            for _ in range(9):
                between = np.linspace(0.0, 1.0, 33)[:, None]
                line = [(1 - between) * a + between * b for a, b in zip(*questions, strict=True)]
                F, _ = allocate.many(*line)
                at = int(np.abs(np.diff(F, axis=0)).max(axis=1).argmax())
                questions = [[part[at + side] for part in line] for side in (0, 1)]
            assert np.abs(F[at + 1] - F[at]).max() <= 1e-6 * vehicle.f_scale, vehicle.name


def test_scaled_meets_whatever_can_be_met(vehicle: Vehicle, rng: np.random.Generator) -> None:
    thrusts = rng.uniform(vehicle.f_min, vehicle.f_max, (50, vehicle.n))
    corners = np.where(rng.random((50, vehicle.n)) < 0.5, vehicle.f_min, vehicle.f_max)
    taus = np.vstack([thrusts, corners]) @ vehicle.TP.T  # corners lie on the very edge, or inside
    for method in ("scaled", "scaled-by-group"):
        allocate = build(method, vehicle)
        assert (allocate.many(taus)[1] == Status.SOLVED).all()
        assert {allocate(tau).share for tau in taus} <= {(1.0,), (1.0, 1.0)}


def test_priority_with_one_level_is_scaled(rng: np.random.Generator) -> None:
    vehicle = load_vehicle("ukwial")
    assert len(vehicle.priority) == 1
    taus = beyond(vehicle, rng, 50)
    np.testing.assert_array_equal(
        build("priority", vehicle).many(taus)[0], build("scaled", vehicle).many(taus)[0]
    )


def test_a_yaw_that_saturates_does_not_slow_heave_where_they_share_no_thruster() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    tau = np.array([0.0, 0.0, 50.0, 0.0, 0.0, 1000.0])
    yaw = alpha_max(vehicle, [[0, 0, 0, 0, 0, 1000.0]])[0]
    straight, grouped = (build(method, vehicle)(tau) for method in ("scaled", "scaled-by-group"))
    np.testing.assert_allclose(vehicle.TP @ straight.f, yaw * tau, atol=1e-9)
    np.testing.assert_allclose(vehicle.TP @ grouped.f, [0, 0, 50.0, 0, 0, yaw * 1000], atol=1e-9)
    np.testing.assert_allclose(grouped.share, [yaw, 1.0], rtol=1e-12)
    assert grouped.status is straight.status is Status.PARTIAL


def test_priority_serves_its_first_level_as_if_the_others_were_not_asked_and_all_as_it_says(
    rng: np.random.Generator,
) -> None:
    """nautilus' thrusters lie above its centre of mass, so surge and sway take from pitch and roll."""
    vehicle = load_vehicle("nautilus")
    levels = [[vehicle.dof.index(axis) for axis in level] for level in vehicle.priority]
    allocate = build("priority", vehicle)
    taus = beyond(vehicle, rng, 100)
    alone = np.zeros_like(taus)
    alone[:, levels[0]] = taus[:, levels[0]]
    for tau, largest in zip(taus, alpha_max(vehicle, alone), strict=True):
        f, _, _, _, share, *_ = allocate(tau)
        assert share[0] == pytest.approx(min(1.0, 0.99 * largest), rel=1e-12)
        for level, delivered in zip(levels, share, strict=True):
            np.testing.assert_allclose((vehicle.TP @ f)[level], delivered * tau[level], atol=1e-9)


def test_a_vertical_thruster_held_by_limits_stops_heave_and_one_that_is_off_does_not() -> None:
    """bluerov2 can't heave by one vertical thruster without rolling; docs/saturation.md explains."""
    vehicle = load_vehicle("bluerov2")
    low, high = vehicle.limits(blocked=[5])
    heave = np.array([0.0, 0.0, 20.0, 0.0, 0.0])
    held, off = build("priority", vehicle)(heave, low, high), build("priority", vehicle.with_fault(5))(heave)
    np.testing.assert_allclose(held.share, [0.0, 1.0, 1.0], atol=1e-12)
    assert set(off.share) == {1.0}
    assert off.status is Status.PARTIAL  # it heaves and holds its roll, at the price of sway
    np.testing.assert_allclose((vehicle.TP @ off.f)[[0, 2, 3, 4]], heave[[0, 2, 3, 4]], atol=1e-9)


@pytest.mark.parametrize("shape", SHAPES)
@methods
def test_it_holds_for_any_vehicle(method: str, shape: tuple[int, int], rng: np.random.Generator) -> None:
    """Vehicles of any nullity, with full H, with limits that exclude zero; all directions count wholly."""
    vehicle = replace(random_vehicle(*shape, rng, diagonal=False), weak_limit=0.0)
    allocate, way = build(method, vehicle), way_of(method, vehicle)
    taus = beyond(vehicle, rng, 20)
    F, _ = allocate.many(taus)
    ends, _ = way.towards_many(taus, way.departure(vehicle.f_min, vehicle.f_max))
    np.testing.assert_allclose((F @ vehicle.TP.T - ends) / vehicle.wrench_scale, 0.0, atol=ROUNDING)
    assert max(not_optimal(vehicle, f, vehicle.f_min, vehicle.f_max) for f in F) <= ROUNDING
