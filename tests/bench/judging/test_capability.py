"""What the record says a vehicle is worth: shares, intervals and sections against the exact ones."""

from contextlib import suppress
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest

from alloc import (
    NotApplicable,
    Vehicle,
    alpha_max,
    attainable_volume,
    closed_form_range,
    closed_form_volume,
    find,
    load_vehicle,
    single_axis_maxima,
)
from bench.demands import build_demands, list_demands
from bench.judging.capability import (
    closed_forms,
    interval,
    measure_served,
    measure_worth,
    measure_worths,
    remaining_authority,
)
from bench.judging.reach import SIZES, corners, error_curve, planes
from bench.record.capability import Worth

UKWIAL, SIX = load_vehicle("ukwial"), load_vehicle("bluerov2")


def test_the_share_served_by_clipping_holds_the_exact_share_of_the_closed_form():
    [served] = measure_served(UKWIAL, None, [find("clip")], seed=1, n=2000)
    exact = closed_form_volume(UKWIAL) / attainable_volume(UKWIAL)
    # Clipping serves those exactly, and a little more within 1 %.
    assert exact < served.within_1pct[2]
    assert served.within_1pct[0] < exact + 0.06
    assert served.within_1pct[0] <= served.within_5pct[0] <= 1


def test_the_exact_method_serves_everything():
    for served in measure_served(SIX, None, [find("nullspace"), find("scaled")], seed=1, n=500):
        assert served.within_1pct[0] == 1
        assert served.within_1pct[1] > 0.99


@pytest.mark.parametrize(("count", "n"), [(0, 20), (20, 20), (7, 20), (1300, 2000)])
def test_intervals_are_those_of_clopper_and_pearson(count: int, n: int):
    expected = binomtest(count, n).proportion_ci(0.95)
    share, low, high = interval(np.arange(n) < count)
    assert share == count / n
    assert (low, high) == pytest.approx((expected.low, expected.high), abs=1e-9)


def test_authority_lists_the_whole_vehicle_and_each_fault():
    whole, *faults = remaining_authority(UKWIAL)
    assert whole.fault is None
    assert whole.volume_share == 1
    assert [f.fault for f in faults] == [0, 1, 2, 3]
    backward, forward = single_axis_maxima(UKWIAL)
    assert whole.axis_min == pytest.approx(backward)
    assert whole.axis_max == pytest.approx(forward)
    for fault in faults:
        degraded = UKWIAL.with_fault(fault.fault)
        assert fault.volume_share == pytest.approx(attainable_volume(degraded) / attainable_volume(UKWIAL))
        assert fault.closed_form_share == pytest.approx(1)  # no freedom is left


def test_lost_rank_is_reported_and_not_measured_away():
    lost = [a for a in remaining_authority(SIX) if a.rank < 5]
    assert [a.fault for a in lost] == [4, 5]
    assert all(a.volume_share == 0 and a.condition is None for a in lost)


def test_a_remainder_that_is_nearly_singular_shows_in_its_condition():
    # Four motors, the last nearly in line with the other two once the first is off: PX4 pull request 28589.
    T = np.array([[1.0, 1.0, 1.0, 0.0], [1.0, -1.0, 1.0, 1e-4], [1.0, 1.0, -1.0, 1e-4]])
    vehicle = replace(UKWIAL, T=T)
    whole, first, *_ = remaining_authority(vehicle)
    assert whole.rank == first.rank == 3
    assert whole.condition is not None
    assert first.condition is not None
    assert whole.condition < 10
    assert first.condition > 1000


def test_an_axis_alone_that_can_not_be_had_is_none_in_the_record():
    forced = replace(UKWIAL, f_min=[10.0, 10, 10, 20], f_max=[11.0, 11, 11, 30])
    assert None in remaining_authority(forced)[0].axis_max


def test_error_grows_from_nothing_to_what_is_out_of_reach():
    for entry in (find("nullspace"), find("scaled"), find("clip")):
        curve = error_curve(UKWIAL, entry, np.random.default_rng(1))
        assert curve is not None
        assert curve.error_max[0] < 1e-9
        beyond = np.array(curve.size) > 1.01
        floor = 1 - 1 / SIZES[beyond]
        if entry.name == "scaled":  # keeps the direction, so it misses exactly the part out of reach
            assert np.array(curve.error_max)[beyond] == pytest.approx(floor, abs=1e-9)
        if entry.name == "nullspace":  # says infeasible, and delivers nothing
            assert set(np.array(curve.error_max)[beyond]) == {1.0}


def test_a_method_that_refuses_the_vehicle_is_left_out():
    assert error_curve(SIX, find("walsh"), np.random.default_rng(1)) is None
    assert measure_served(SIX, None, [find("walsh")], seed=1, n=10) == []


@pytest.mark.parametrize("name", ["ukwial", "bluerov2-heavy"])
def test_outlines_lie_on_the_edge_of_their_sets(name: str):
    vehicle = load_vehicle(name)
    for plane in planes(vehicle, seed=1):
        axes = [vehicle.dof.index(plane.x), vehicle.dof.index(plane.y)]
        for outline, on_edge in (
            (plane.attainable, lambda tau: alpha_max(vehicle, tau)),
            (plane.closed_form, lambda tau: closed_form_range(vehicle, tau)[1]),
        ):
            points = np.array([*outline, outline[0]])
            points = np.vstack([points[:-1], (points[1:] + points[:-1]) / 2])  # corners and sides
            taus = np.zeros((len(points), vehicle.k))
            taus[:, axes] = points
            taus[:, vehicle.dof.index(plane.held)] = plane.held_at
            assert on_edge(taus) == pytest.approx(1, abs=1e-4)  # six digits are kept
        assert len(plane.demands) == (0 if plane.held_at else 150)


@given(sides=st.integers(3, 12), turn=st.floats(0, 6.2), stretch=st.floats(0.01, 100))
@settings(deadline=None)
def test_corners_are_found_between_the_points_of_an_edge(sides: int, turn: float, stretch: float):
    angles = np.linspace(0, 2 * np.pi, sides, endpoint=False) + turn
    polygon = np.column_stack([np.cos(angles), stretch * np.sin(angles)])
    shares = np.linspace(0.02, 0.98, 5)  # no point on a corner
    nexts = np.roll(polygon, -1, axis=0)
    edge = np.concatenate([a + shares[:, None] * (b - a) for a, b in zip(polygon, nexts, strict=True)])
    np.testing.assert_allclose(corners(edge), nexts, atol=1e-6 * max(1, stretch))


def test_a_corner_that_is_itself_a_point_is_found_once():
    square = [[1, 0], [1, 0.5], [1, 1], [0.5, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]]
    found = corners(np.array(square, dtype=float))
    assert sorted(map(tuple, found)) == [(-1, -1), (-1, 1), (1, -1), (1, 1)]


def test_a_vehicle_without_sway_has_no_such_plane():
    one = Vehicle(
        "one", ("surge",), np.eye(1), np.eye(1), np.array([-1.0]), np.ones(1), np.ones(1), np.ones(1)
    )
    assert planes(one, seed=1) == []
    assert len(remaining_authority(one)) == 1


ODD = {
    "an axis that nothing moves": replace(UKWIAL, T=UKWIAL.T * np.array([[1], [0], [1]])),
    "thrusters that can't reverse": replace(UKWIAL, f_min=np.zeros(4)),
    "thrusters that must push": replace(UKWIAL, f_min=[10.0, 10, 10, 20], f_max=[11.0, 11, 11, 30]),
    "a thruster held at one thrust": replace(UKWIAL, f_min=[-250, -250, -250, 5], f_max=[250, 250, 250, 5]),
    "two thrusters off": UKWIAL.with_fault(0).with_fault(1),
    "one thruster left": UKWIAL.with_fault(0).with_fault(1).with_fault(2),
    "a thruster hardly there": UKWIAL.with_fault(0, 1e-3),
}


@pytest.mark.parametrize("vehicle", ODD.values(), ids=ODD)
def test_an_odd_vehicle_has_a_worth_and_each_demand_set_or_a_reason(vehicle: Vehicle):
    worth = measure_worth(vehicle, seed=1, n=50)
    assert msgspec.json.decode(msgspec.json.encode(worth), type=Worth) == worth
    assert {0.0 <= a.volume_share <= 1.0 + 1e-9 for a in worth.authority} == {True}
    for name in list_demands():
        with suppress(NotApplicable):
            found = build_demands(name, vehicle, seed=1, n=40)
            assert found.taus.shape == (40, vehicle.k)
            assert np.isfinite(found.taus).all()


def test_thrusters_without_any_choice_have_no_worth():
    held = replace(UKWIAL, f_min=np.ones(4), f_max=np.ones(4))
    assert list(measure_worths([], seed=1, known=())) == []
    with pytest.raises(NotApplicable):
        measure_worth(held, seed=1)


def test_worth_survives_the_record_and_names_no_solver():
    worth = measure_worth(UKWIAL, seed=1, n=100)
    again = msgspec.json.decode(msgspec.json.encode(worth), type=Worth)
    assert again == worth
    assert measure_worth(UKWIAL, seed=1, n=100) == worth
    methods = {served.method for served in worth.served}
    assert {"pinv", "clip", "scaled", "nullspace"} <= methods
    assert not [entry.name for entry in closed_forms() if "/" in entry.name]
    assert {served.fault for served in worth.served} == {None, 0}
