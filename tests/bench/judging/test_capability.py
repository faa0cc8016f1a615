"""The capability of a vehicle in the record: shares, authority and sections against exact values."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest

from alloc import NotApplicable, Vehicle, alpha_max, build, load_vehicle
from alloc.reach.attainable import closed_form_range, single_axis_maxima
from alloc.reach.volumes import attainable_volume, closed_form_volume, uniform_demands
from bench.demands import build_demands, list_demands
from bench.demands.store import Case
from bench.judging.capability import (
    SIZES,
    corners,
    limit_wrenches,
    measure_capabilities,
    planes,
    remaining_authority,
    worst_loss,
)
from bench.judging.question import Answers, Ask, Unanswered, ask_here
from bench.record import Capability, Served

UKWIAL, SIX = load_vehicle("ukwial"), load_vehicle("bluerov2")


def capability(vehicle: Vehicle, *methods: str, n: int = 100, ask: Ask = ask_here) -> Capability:
    (measured,) = measure_capabilities([vehicle], methods, seed=1, ask=ask, n=n)
    return measured


def served(vehicle: Vehicle, method: str, n: int) -> Served:
    """Share of the whole vehicle that the method serves."""
    return next(s for s in capability(vehicle, method, n=n).served if s.fault is None)


def test_clipping_serves_the_exact_share_of_the_closed_form_and_little_more():
    clip = served(UKWIAL, "clip", n=2000)
    exact = closed_form_volume(UKWIAL) / attainable_volume(UKWIAL)
    # Clipping serves what the closed form serves, and a little more with an error within 1 %.
    assert exact < binomtest(clip.within_1pct, 2000).proportion_ci(0.95).high
    assert clip.within_1pct / 2000 < exact + 0.06
    assert clip.within_1pct <= clip.within_5pct <= 2000


def test_each_demand_that_is_missed_has_its_bit():
    clip, shrink = (served(UKWIAL, method, n=100) for method in ("clip", "shrink"))
    bits = [np.unpackbits(np.frombuffer(s.missed, np.uint8), count=100) for s in (clip, shrink)]
    assert [100 - int(own.sum()) for own in bits] == [clip.within_1pct, shrink.within_1pct]
    assert (bits[0] <= bits[1]).all()  # what fits unclipped is met by both
    assert bits[0].any()


@pytest.mark.parametrize("method", ["nullspace", "scaled"])
def test_exact_methods_serve_every_attainable_demand(method: str):
    assert served(SIX, method, n=500).within_1pct == 500


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


def test_authority_without_full_rank_has_no_volume_and_no_condition():
    lost = [a for a in remaining_authority(SIX) if a.rank < 5]
    assert [a.fault for a in lost] == [4, 5]
    assert all(a.volume_share == 0 and a.condition is None for a in lost)


def test_a_nearly_singular_vehicle_has_a_large_condition():
    # Four motors, the last nearly in line with the other two once the first is off: PX4 pull request 28589.
    T = np.array([[1.0, 1.0, 1.0, 0.0], [1.0, -1.0, 1.0, 1e-4], [1.0, 1.0, -1.0, 1e-4]])
    vehicle = replace(UKWIAL, T=T, weak_limit=0.0)
    whole, first, *_ = remaining_authority(vehicle)
    assert whole.rank == first.rank == 3
    assert whole.condition is not None
    assert first.condition is not None
    assert whole.condition < 10
    assert first.condition > 1000
    assert [a.rank for a in remaining_authority(replace(UKWIAL, T=T))[:2]] == [3, 2]  # weak by 1 % of T


def test_the_maximum_of_an_axis_that_can_not_be_pushed_alone_is_none():
    forced = replace(UKWIAL, f_min=[10.0, 10, 10, 20], f_max=[11.0, 11, 11, 30])
    assert None in remaining_authority(forced)[0].axis_max


@pytest.mark.parametrize("method", ["nullspace", "scaled", "clip"])
def test_error_curves_go_from_zero_to_the_unattainable_share(method: str):
    (curve,) = capability(UKWIAL, method).curves
    assert curve.error_max[0] < 1e-9
    beyond = np.array(curve.size) > 1.01
    floor = 1 - 1 / SIZES[beyond]
    if method == "scaled":  # it keeps the direction, so it misses exactly the unattainable part
        assert np.array(curve.error_max)[beyond] == pytest.approx(floor, abs=1e-9)
    if method == "nullspace":  # it answers INFEASIBLE, so it delivers nothing
        assert set(np.array(curve.error_max)[beyond]) == {1.0}


def test_a_method_that_refuses_the_vehicle_is_left_out():
    measured = capability(SIX, "walsh")
    assert (measured.served, measured.unserved, measured.curves) == ([], [], [])


def test_a_method_that_crashes_is_named_with_its_reason_and_the_others_are_counted():
    def ask(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
        return (
            ask_here(method, cases) if method == "pinv" else [Unanswered("crashed", "SIGSEGV")] * len(cases)
        )

    measured = capability(UKWIAL, "mine", "pinv", ask=ask)
    assert [(u.method, u.status, u.reason) for u in measured.unserved] == [("mine", "crashed", "SIGSEGV")]
    assert {s.method for s in measured.served} == {"pinv"}
    assert [curve.method for curve in measured.curves] == ["pinv"]


def test_a_method_that_fails_with_a_thruster_off_says_which():
    def ask(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
        failed = Unanswered("failed", "LinAlgError: Singular matrix")
        return [failed if case.vehicle.faults else ask_here("pinv", [case])[0] for case in cases]

    (unserved,) = capability(UKWIAL, "mine", ask=ask).unserved
    assert unserved.reason == "with thruster 0 off: LinAlgError: Singular matrix"


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
    assert sorted(map(tuple, corners(np.array(square, dtype=float)))) == [(-1, -1), (-1, 1), (1, -1), (1, 1)]


def test_a_vehicle_without_sway_and_yaw_has_no_planes():
    one = Vehicle(
        name="one",
        dof=("surge",),
        T=np.eye(1),
        H=np.eye(1),
        f_min=np.array([-1.0]),
        f_max=np.ones(1),
        readiness=np.ones(1),
        slack_weights=np.ones(1),
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


FEW = ("an axis that nothing moves", "thrusters that must push", "one thruster left")
"""Vehicles that differ most; the others are asked with ``-m long``."""


@pytest.mark.parametrize(
    "vehicle",
    [
        pytest.param(each, id=name, marks=() if name in FEW else pytest.mark.long)
        for name, each in ODD.items()
    ],
)
def test_an_odd_vehicle_has_a_capability_and_each_demand_set_or_a_reason(vehicle: Vehicle):
    measured = capability(vehicle, "pinv", "nullspace", n=50)
    assert msgspec.json.decode(msgspec.json.encode(measured), type=Capability) == measured
    assert {0.0 <= a.volume_share <= 1.0 + 1e-9 for a in measured.authority} == {True}
    for name in list_demands():
        with suppress(NotApplicable):
            demands = build_demands(name, vehicle, seed=1, n=40)
            assert demands.taus.shape == (40, vehicle.k)
            assert np.isfinite(demands.taus).all()


def test_a_vehicle_whose_thrusters_have_no_choice_has_no_capability():
    held = replace(UKWIAL, f_min=np.ones(4), f_max=np.ones(4))
    assert measure_capabilities([held], ["pinv"], seed=1, ask=ask_here) == []


def test_a_capability_is_reproducible_and_covers_the_worst_fault():
    measured = capability(UKWIAL, "pinv", "clip")
    assert capability(UKWIAL, "pinv", "clip") == measured
    assert [(s.fault, s.method) for s in measured.served] == [
        (None, "pinv"),
        (None, "clip"),
        (0, "pinv"),
        (0, "clip"),
    ]


def test_the_worst_is_kept_of_demands_drawn_and_of_every_corner_that_thrusters_make():
    """A corner loses more than any of the demands drawn, and no fresh corner more than those gone through."""
    (pinv, degraded) = capability(UKWIAL, "pinv", n=200).served
    assert pinv.sample is not None
    assert pinv.corners is not None
    assert (pinv.sample.n_demands, pinv.corners.n_demands) == (200, 2**4)
    assert degraded.sample is not None
    assert degraded.corners is None
    drawn = uniform_demands(UKWIAL, np.random.default_rng(1), 200)
    rng = np.random.default_rng(2)
    ends = np.where(rng.random((5000, 4)) < 0.5, UKWIAL.f_min, UKWIAL.f_max) @ UKWIAL.TP.T
    for kept, taus in ((pinv.sample, drawn), (pinv.corners, ends)):
        again = worst_loss(UKWIAL, taus, build("pinv", UKWIAL).many(taus)[0])
        assert (kept.missed_max, kept.turned_max_deg) == (again.missed_max, again.turned_max_deg)
    assert pinv.corners.missed_max > pinv.sample.missed_max


def test_a_demand_without_thrusts_is_lost_whole_and_many_thrusters_have_no_corners_gone_through():
    refused = worst_loss(UKWIAL, np.ones((2, 3)), np.array([[np.nan] * 4, [1.0] * 4]))
    assert (refused.n_demands, refused.n_answers, refused.missed_max) == (2, 1, 1.0)
    doubled = {key: np.tile(getattr(UKWIAL, key), 3) for key in ("T", "f_min", "f_max", "readiness")}
    twelve = replace(UKWIAL, **doubled, H=np.eye(12), slew=None, poses=None)
    assert limit_wrenches(twelve).shape == (0, 3)
