"""Length of a way towards a demand: by facets, and by linear programs that know nothing of facets."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import NotApplicable, Status, Vehicle, alpha_max, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.c import missing
from alloc.nullspace.structure import decompose
from alloc.reach.edge import start
from alloc.reach.way import KEEP, Way, groups, step_maps
from alloc.vehicle.geometry import DOF
from bench.demands.generated import drawn_demands, generate_vehicle, growth_vehicle
from saturation import limits, share_by_program, vehicles

LP = 1e-8
"""Error of a share by HiGHS: it works to 1e-10 in scaled wrench, and a step may be 1e-2 long."""


def way(vehicle: Vehicle) -> Way:
    """The way of the vehicle's priority; where the file has none, an axis a level."""
    levels = vehicle.priority if len(vehicle.priority) > 1 else [[axis] for axis in vehicle.dof]
    return Way(vehicle, levels, [KEEP] * (len(levels) - 1) + [1.0])


def test_the_share_of_each_level_is_that_of_a_linear_program(rng: np.random.Generator) -> None:
    """From the same wrench, so that what one level leaves of rounding does not count against the next."""
    for vehicle in vehicles():
        through = way(vehicle)
        maps = step_maps(vehicle, through.levels)
        low, high = limits(vehicle, rng, 4)
        taus = rng.normal(size=(4, vehicle.k)) * vehicle.wrench_scale
        begin = through.departure(low, high)
        _, shares = through.towards_many(taus, begin)
        for i, tau in enumerate(taus):
            w = begin.wrench[i]
            for D, keep, share in zip(maps, through.keep, shares[i], strict=True):
                step = D @ (tau - w)
                if np.abs(step / vehicle.wrench_scale).max() > 1e-2:
                    expected = share_by_program(vehicle, w, step, low[i], high[i], keep)
                    assert share == pytest.approx(expected, abs=LP), vehicle.name
                w = w + share * step


def test_straight_from_zero_it_is_the_largest_attainable_share(
    vehicle: Vehicle, rng: np.random.Generator
) -> None:
    taus = rng.normal(size=(50, vehicle.k)) * vehicle.wrench_scale
    straight = Way(vehicle, [vehicle.dof], [1.0])
    end, shares = straight.towards_many(taus, straight.departure(vehicle.f_min, vehicle.f_max))
    expected = np.minimum(1.0, alpha_max(vehicle, taus))
    np.testing.assert_allclose(shares[:, 0], expected, rtol=1e-12)
    np.testing.assert_allclose(end, expected[:, None] * taus, rtol=1e-12)


def test_one_demand_and_many_give_the_same(rng: np.random.Generator) -> None:
    """An axis a level: where two are pushed together only, a level moves what later ones start from."""
    for vehicle in vehicles():
        through = Way(vehicle, [[axis] for axis in vehicle.dof], [KEEP] * (vehicle.k - 1) + [1.0])
        low, high = limits(vehicle, rng, 20)
        taus = rng.normal(size=(20, vehicle.k)) * vehicle.wrench_scale * np.logspace(-3, 3, 20)[:, None]
        ends, shares = through.towards_many(taus, through.departure(low, high))
        for i, tau in enumerate(taus):
            end, share = through.towards(tau, through.departure(low[i], high[i]))
            np.testing.assert_allclose((end - ends[i]) / vehicle.wrench_scale, 0.0, atol=1e-12)
            np.testing.assert_allclose(share, shares[i], atol=1e-9)  # of a step 1e-3 as large as the set


def test_where_only_rounding_is_missing_all_is_delivered(rng: np.random.Generator) -> None:
    """Every thruster is stuck, and what they push is asked for: a sum in another order must not miss it."""
    vehicle = load_vehicle("bluerov2-heavy")
    stuck = rng.uniform(vehicle.f_min, vehicle.f_max, (200, vehicle.n))
    taus = np.array([vehicle.TP.dot(f) for f in stuck])
    allocate = build("scaled", vehicle)
    assert (allocate.many(taus, stuck, stuck)[1] == Status.SOLVED).all()
    assert {allocate(tau, f, f).status for tau, f in zip(taus, stuck, strict=True)} == {Status.SOLVED}


def test_a_demand_that_nothing_stops_is_reached_to_the_bit(
    vehicle: Vehicle, rng: np.random.Generator
) -> None:
    through = way(vehicle)
    begin = through.departure(vehicle.f_min, vehicle.f_max)
    tau = 1e-3 * rng.normal(size=vehicle.k) * vehicle.wrench_scale
    end, share = through.towards(tau, begin)
    np.testing.assert_array_equal(end, tau)
    assert set(share) == {1.0}


def test_a_level_that_others_follow_leaves_a_hundredth_of_its_way_and_the_last_goes_to_the_edge() -> None:
    """A thruster ahead and one across, +-1 N each, push a square; sway alone is not in surge's way."""
    ends = np.ones(2)
    square = Vehicle("square", ("surge", "sway"), np.eye(2), np.eye(2), -ends, ends, ends, ends)
    square = replace(square, priority=(("surge",), ("sway",)))
    through = way(square)
    end, share = through.towards(np.array([4.0, 4.0]), through.departure(square.f_min, square.f_max))
    np.testing.assert_allclose(end, [0.99, 1.0], rtol=1e-12)
    np.testing.assert_allclose(share, [0.99 / 4, 1 / 4], rtol=1e-12)


sizes = st.floats(-1e100, 1e100)


@given(sizes, sizes)
def test_a_start_lies_inside_the_limits_and_at_zero_where_they_allow_it(a: float, b: float) -> None:
    low, high = np.array([min(a, b)]), np.array([max(a, b)])
    f0 = start(low, high)
    assert low <= f0 <= high
    if low <= 0 <= high:
        assert f0 == 0


@given(st.floats(0.0, 10.0), st.floats(1e-3, 10.0))
def test_a_start_is_the_end_nearest_to_zero_moved_inwards_by_it_or_by_a_twentieth(
    low: float, width: float
) -> None:
    high = low + width
    inset = min(low, (high - low) / 20)
    assert start(np.array([low]), np.array([high])) == pytest.approx(low + inset, rel=1e-12)
    assert start(np.array([-high]), np.array([-low])) == pytest.approx(-low - inset, rel=1e-12)


def lost_rank() -> list[Vehicle]:
    return [vehicle for vehicle in vehicles() if vehicle.rank < vehicle.k]


def test_where_a_direction_is_lost_a_step_comes_as_near_as_it_can_and_leaves_earlier_axes_alone() -> None:
    """The least squares of each level, worked out again by a null space of the levels before it.

    No direction of these vehicles lies on a level's axes by a little, which would leave it to later levels.
    """
    assert lost_rank()
    for vehicle in lost_rank():
        levels = [vehicle.dof[2:], vehicle.dof[:1], vehicle.dof[1:2]]
        unit = vehicle.row_lengths
        scaled = vehicle.TP / unit[:, None]
        before: list[int] = []
        for level, D in zip(levels, step_maps(vehicle, levels), strict=True):
            rows = [vehicle.dof.index(axis) for axis in level]
            moves = D * unit / unit[:, None]  # both sides in unit of row_lengths
            np.testing.assert_allclose(decompose(vehicle).unreachable @ D * vehicle.f_scale, 0.0, atol=1e-9)
            np.testing.assert_allclose(moves[before], 0.0, atol=1e-9)
            _, sigma, Vt = np.linalg.svd(scaled[before])
            free = scaled @ Vt[np.count_nonzero(sigma > 1e-9) :].T  # wrenches that move no earlier axis
            U, length, _ = np.linalg.svd(free[rows])
            reached = U[
                :, : np.count_nonzero(length > 1e-9)
            ]  # of what the level's axes ask for, the part there is
            np.testing.assert_allclose(moves[rows], reached @ reached.T @ np.eye(vehicle.k)[rows], atol=1e-9)
            before += rows


def test_groups_share_no_thruster_and_hold_all_axes() -> None:
    for vehicle in vehicles():
        found = groups(vehicle)
        assert sorted(axis for group in found for axis in group) == sorted(vehicle.dof)
        movers = [
            {i for axis in group for i in np.flatnonzero(vehicle.TP[vehicle.dof.index(axis)])}
            for group in found
        ]
        assert sum(map(len, movers)) == len(set().union(*movers)), vehicle.name
    heavy = groups(load_vehicle("bluerov2-heavy"))
    assert heavy == (("surge", "sway", "yaw"), ("heave", "roll", "pitch"))
    assert len(groups(load_vehicle("nautilus"))) == 1  # its thrusters lie above the centre of mass


def test_a_vehicle_with_too_many_facets_is_refused() -> None:
    with pytest.raises(NotApplicable, match="more than 50000 facets"):
        way(growth_vehicle(6, 32))


def along_a_facet(rng: np.random.Generator, n: int) -> tuple[Vehicle, FloatArray, FloatArray, FloatArray]:
    """A vehicle of which one thruster alone has a choice: n demands that it pushes, and their limits.

    The ways run in every facet in which that thruster pushes, where there is no room at all: what they leave
    by is the rounding of what the stuck thrusters push, which is large against the way, and of every other
    demand against the wrench too, as the stuck thrusters push next to nothing.
    """
    k = int(rng.integers(2, 5))
    T = rng.normal(size=(k, k + 2))
    ends = rng.uniform(1.0, 100.0, k + 2)
    vehicle = Vehicle("stuck", DOF[:k], T, np.eye(k + 2), -ends, ends, np.ones(k + 2), np.full(k, 2000.0))
    vehicle = replace(vehicle, weak_limit=0.0)  # a direction that counts in part has another way
    low = rng.uniform(vehicle.f_min, vehicle.f_max, (n, vehicle.n))
    low[::2] -= low[::2] @ T.T @ np.linalg.pinv(T).T
    high = low.copy()
    high[:, -1] += 10.0 ** rng.uniform(-9, 0, n)
    taus = rng.uniform(low, high) @ vehicle.TP.T
    return vehicle, taus, low, high


def all_solved(method: str, vehicle: Vehicle, taus: FloatArray, low: FloatArray, high: FloatArray) -> None:
    allocate = build(method, vehicle)
    assert {allocate(*call).status for call in zip(taus, low, high, strict=True)} == {Status.SOLVED}, method
    assert set(allocate.many(taus, low, high)[1]) == {Status.SOLVED}, method


def test_a_way_that_runs_in_a_facet_is_not_stopped_by_rounding(rng: np.random.Generator) -> None:
    for _ in range(50):
        case = along_a_facet(rng, 20)
        all_solved("scaled", *case)
        all_solved("priority", *case)


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@pytest.mark.parametrize("method", ["scaled@native", "priority@native"])
def test_nor_is_it_in_generated_c(method: str, rng: np.random.Generator) -> None:
    all_solved(method, *along_a_facet(rng, 200))


def test_one_call_and_many_agree_about_a_way_in_a_facet() -> None:
    """Vehicle 7947 of the campaign, one of whose thrusters is stuck: the second way is 1e-4 of the set."""
    vehicle, rng = generate_vehicle(7947)
    taus, low, high = drawn_demands(vehicle, rng)[1][:3]
    for method in ("scaled", "priority", "scaled-by-group"):
        allocate = build(method, vehicle)
        each = [allocate(*call).status for call in zip(taus, low, high, strict=True)]
        assert (allocate.many(taus, low, high)[1] == each).all(), method
