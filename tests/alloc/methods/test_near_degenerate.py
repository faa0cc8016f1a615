"""Answers on vehicles that are symmetric but for their last digits, held against their equation."""

from dataclasses import replace
from functools import partial
from itertools import count
from typing import Any, cast

import numpy as np
import pytest

from alloc import Allocator, NotApplicable, Status, Vehicle, build, generate, load_vehicle
from alloc.allocation import FloatArray
from alloc.formulations import find_formulation
from alloc.kernels import by_level
from alloc.kernels.correction import Correction
from alloc.kernels.exact import Piece, piece
from alloc.methods import recipe
from alloc.nullspace import region, structure
from alloc.nullspace.allocator import Nullspace
from alloc.nullspace.structure import Block
from alloc.program import Evaluated, Expression, Scalar, Where, evaluate
from alloc.reach import attainable, edge, zonotope
from alloc.vehicle import degeneracy
from bench.demands import build_demands
from bench.demands.generated import edge_demands, numbered
from tests.vehicles import made_by_few, made_up

VEHICLES, DEMANDS = 100, 60
OFF = 1e-9 + 1e-15
"""Largest error of a wrench, relative to ``wrench_scale``, and what rounding takes of T f."""
RULES = ["clip", "shrink", "redistribute", "group-scaling"]
AHEAD = [2, 164, 209]
"""Vehicles on which no thruster reverses, of which Python or C said a share of 0 where all can be made."""
WHOLE = 1 - 1e-5
"""Share that rounding of 1e-13 leaves of a facet 1e-8 away."""
EXACT = ["nullspace", "scaled", "scaled-by-group", "priority"]


@pytest.fixture(scope="module")
def cases() -> list[tuple[Vehicle, FloatArray]]:
    return [(vehicle, edge_demands(vehicle, rng, DEMANDS)) for vehicle, rng in map(numbered, range(VEHICLES))]


def promised(vehicle: Vehicle, formulation: str, taus: FloatArray, shares: FloatArray) -> FloatArray:
    """Wrenches (N, k) that answers with these shares (N, levels) say they make."""
    way_of = find_formulation(formulation).way
    if way_of is None:
        return taus
    way = way_of(vehicle)
    return way.delivered(taus, way.departure(vehicle.f_min, vehicle.f_max), shares)


@pytest.mark.parametrize("method", EXACT)
def test_thrusts_make_the_wrench_that_status_and_share_say(
    method: str, cases: list[tuple[Vehicle, FloatArray]]
) -> None:
    off = {}
    for number, (vehicle, taus) in enumerate(cases):
        allocate = build(method, vehicle)
        answers = [allocate(tau) for tau in taus]
        says = promised(vehicle, allocate.formulation, taus, np.array([answer.share for answer in answers]))
        F = np.array([answer.f for answer in answers])
        answered = np.array([answer.status in (Status.SOLVED, Status.PARTIAL) for answer in answers])
        error = (np.abs(F @ vehicle.TP.T - says) / vehicle.wrench_scale)[answered].max(initial=0.0)
        assert ((vehicle.f_min <= F) & (vehicle.f_max >= F))[answered].all()
        if not error <= OFF:
            off[f"{number} {vehicle.name}"] = error
    assert off == {}


@pytest.mark.parametrize("method", [*EXACT, *RULES])
def test_solved_makes_the_demand_to_a_billionth_and_many_demands_get_the_status_of_one_call(
    method: str, cases: list[tuple[Vehicle, FloatArray]]
) -> None:
    solved = 0
    for vehicle, taus in cases[: VEHICLES // 2]:
        allocate, beyond = build(method, vehicle), taus.copy()
        beyond[::2] *= 1 + 1e-9  # so near to the edge that no thruster lies beyond its limits by much
        F, status = allocate.many(beyond)
        answers = [allocate(tau) for tau in beyond]
        assert status.tolist() == [answer.status for answer in answers]
        for thrusts in (F, np.array([answer.f for answer in answers])):
            error = np.abs(thrusts @ vehicle.TP.T - beyond)[status == Status.SOLVED] / vehicle.wrench_scale
            assert error.max(initial=0.0) <= OFF
        solved += np.count_nonzero(status == Status.SOLVED)
    assert solved > 50


@pytest.mark.parametrize("number", AHEAD)
def test_what_thrusts_inside_limits_make_is_delivered_whole_where_no_thruster_reverses(number: int) -> None:
    """At rest such a vehicle stands on a vertex, and a step in one of its facets left it by rounding."""
    vehicle, rng = numbered(number)
    taus = made_by_few(vehicle, rng, 150)
    allocate = build("scaled", vehicle)
    shares = {"Python": np.array([allocate(tau).share[0] for tau in taus])}
    assert (allocate.many(taus)[1] == Status.SOLVED).all()
    for limits in ("fixed", "call"):
        shares[limits] = in_c(vehicle, "scaled", "double", limits, taus).share[:, 0]
    assert {where: share.min() for where, share in shares.items() if not share.min() > WHOLE} == {}


@pytest.mark.parametrize("factor", [0.1, 10.0])
def test_no_answer_hangs_on_where_rounding_is_taken_to_begin(
    factor: float, cases: list[tuple[Vehicle, FloatArray]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """All thresholds of what counts as flat, collinear or zero, ten times larger or smaller."""
    some = [(vehicle, taus[:20]) for vehicle, taus in cases if vehicle.n <= 8][:8]
    before = [np.array([build("scaled", vehicle)(tau).share for tau in taus]) for vehicle, taus in some]
    for room in (zonotope, attainable, edge, region, structure):
        for name in {"COLLINEAR", "FLAT", "NOTHING", "ROUNDED"} & {*vars(room)}:
            monkeypatch.setattr(room, name, factor * getattr(degeneracy, name))
    for (vehicle, taus), shares in zip(some, before, strict=True):
        another = replace(vehicle)  # facets of a vehicle are found once
        allocate = build("scaled", another)
        answers = [allocate(tau) for tau in taus]
        says = promised(another, "scaled", taus, np.array([answer.share for answer in answers]))
        F = np.array([answer.f for answer in answers])
        assert (np.abs(F @ vehicle.TP.T - says) / vehicle.wrench_scale).max() <= OFF
        np.testing.assert_allclose([answer.share for answer in answers], shares, rtol=0, atol=1e-6)


def nearly_planar(lost: float) -> Vehicle:
    """Four thrusters in three degrees of freedom, the last of which all but hangs on the first."""
    T = np.array([[1.0, 1.0, -1.0, -1.0], [0.5, -0.5, 0.5, -0.5], [1.0, 1.0, -1.0, -1.0]])
    T[2] += lost * np.array([1.0, -1.0, -1.0, 1.0])
    vehicle = load_vehicle("ukwial")
    return replace(vehicle, T=T, weak_limit=0.0)


@pytest.mark.parametrize("method", ["nullspace", "scaled", "pinv"])
def test_c_in_float_is_refused_where_single_precision_misses_wrenches(method: str) -> None:
    """Rounding of 6e-8 times a condition of 2,000 is 1.2e-4 of what the thrusters can do."""
    with pytest.raises(NotApplicable, match=r"condition 2e\+03, .* up to 0\.0001 of .* leave out --float"):
        generate(nearly_planar(1e-3), method, scalar="float")
    assert generate(nearly_planar(1e-3), method, scalar="double")
    assert generate(nearly_planar(1e-1), method, scalar="float")


@pytest.mark.parametrize("where", ["Python", "library", "fixed", "call"])
def test_a_thruster_that_hardly_pushes_across_a_facet_counts_for_what_it_does(where: str) -> None:
    """Thrusters 0 and 1 go ahead and astern; to port only 1 pushes, by 9e-14 N a newton.

    A step by 2e-10 N to port for a newton ahead is made to 9e-14 / 2e-10 of what 1 can do; left out as
    rounding, the push made it a share of zero.
    """
    vehicle = made_up([[1.0, 1.0, 0.0], [0.0, 9e-14, -1.0]], [-60.0, -60.0, 0.0], 60.0)
    tau = np.array([60.0, 60.0 * 2e-10])
    if where in ("Python", "library"):
        share = build("scaled" if where == "Python" else "scaled@library", vehicle)(tau).share[0]
    else:
        share = in_c(vehicle, "scaled", "double", cast(Where, where), tau[None]).share[0, 0]
    # The facet along thruster 1 has a margin of 9e-14 of 0's thrust, and the demand leaves it by 9e-14 less.
    assert share == pytest.approx(9e-14 / 2e-10, rel=1e-3)


def test_facets_of_the_library_keep_their_room_where_thrusters_hardly_push_across_them() -> None:
    """Small pushes of 125 facets would be stored, more than the room for a vehicle of this size."""
    vehicle, rng = numbered(785)
    allocate, library = build("scaled", vehicle), build("scaled@library", vehicle)
    for tau in edge_demands(vehicle, rng, 20):
        assert library(tau).share[0] == pytest.approx(allocate(tau).share[0], abs=1e-9)


def spoiled(method: str, good: int, monkeypatch: pytest.MonkeyPatch) -> Allocator:
    """A method whose steps leave thrusts anywhere, but for the last of every ``good`` + 1 times."""
    allocate = build(method, load_vehicle("bluerov2-heavy"))
    by_level = getattr(allocate, "_uncapped", allocate)
    exact = allocate if isinstance(allocate, Nullspace) else by_level._exact
    right, times = exact._moved, count(1)

    def astray(thrusts: list[float], limits: list[tuple[float, float]]) -> int | None:
        steps: int | None = right(thrusts, limits)
        if next(times) % (good + 1):
            thrusts[:] = [-1000.0] * len(thrusts)
        return steps

    monkeypatch.setattr(exact, "_moved", astray)
    return allocate


@pytest.mark.parametrize("method", ["nullspace", "scaled", "priority"])
def test_steps_that_went_astray_are_taken_again(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    tau = vehicle.T @ np.array([60.0, -40.0, 60.0, 60.0, 60.0, 60.0, 60.0, 60.0])
    right, allocate = build(method, vehicle)(tau), spoiled(method, 1, monkeypatch)
    answers = [allocate(tau), allocate(tau)]
    F, statuses = allocate.many([tau, tau])
    for f, status in [*((answer.f, answer.status) for answer in answers), *zip(F, statuses, strict=True)]:
        assert status == right.status
        np.testing.assert_allclose(vehicle.T @ (f - right.f), 0.0, rtol=0, atol=1e-9 * vehicle.f_scale)


def test_what_never_makes_the_wrench_is_not_called_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    tau = load_vehicle("bluerov2-heavy").T @ np.array([60.0, -40.0, 60.0, 60.0, 60.0, 60.0, 60.0, 60.0])
    answer = spoiled("nullspace", 10**9, monkeypatch)(tau)
    assert answer.status is Status.NOT_CONVERGED
    assert np.isnan(answer.f).all()


@pytest.mark.parametrize("method", ["scaled", "priority"])
def test_what_never_makes_the_end_of_the_way_says_a_smaller_share(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    tau = vehicle.T @ np.array([60.0, -40.0, 60.0, 60.0, 60.0, 60.0, 60.0, 60.0])
    answer = spoiled(method, 10**9, monkeypatch)(tau)
    assert answer.status is Status.PARTIAL
    says = promised(vehicle, method, tau[None], np.array([answer.share]))[0]
    np.testing.assert_allclose(vehicle.T @ answer.f, says, rtol=0, atol=1e-9 * vehicle.f_scale)
    assert max(answer.share) < 0.6  # as far as G alone stays inside limits


def in_c(vehicle: Vehicle, method: str, scalar: Scalar, limits: Where, taus: FloatArray) -> Evaluated:
    """Answers of generated C."""
    program = recipe(method).make(vehicle, limits, scalar)
    own = [np.tile(side, (len(taus), 1)) for side in (vehicle.f_min, vehicle.f_max)]
    return evaluate(program, taus, *(own if limits == "call" else []))


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize(
    ("number", "method", "scalar"),
    [
        (880, "nullspace", "double"),
        (12, "priority", "float"),
        (94, "priority", "float"),
        (13, "shrink", "double"),
        (5, "nullspace", "double"),
    ],
)
def test_c_makes_the_wrench_that_status_and_share_say(
    number: int, method: str, scalar: Scalar, limits: Where
) -> None:
    """Vehicles of which C was off by 2.6e-9 in double, by 1.5e-5 and 3.4e-5 in float.

    Nullspace and shrink missed demands a billionth beyond the edge by 1.7e-9 and 5e-9, and said SOLVED.
    """
    vehicle, rng = numbered(number)
    taus = edge_demands(vehicle, rng, 1000) * (1 + 1e-9)
    if scalar == "float":
        taus = taus.astype(np.float32).astype(float)
    got = in_c(vehicle, method, scalar, limits, taus)
    says = promised(vehicle, recipe(method).formulation, taus, got.share)
    answered = np.isin(got.status, (Status.SOLVED, Status.PARTIAL) if got.share.size else (Status.SOLVED,))
    error = (np.abs(got.F @ vehicle.TP.T - says) / vehicle.wrench_scale)[answered]
    assert answered.sum() > 300
    assert error.max() <= (OFF if scalar == "double" else 1e-5)


def test_c_of_redistribute_says_solved_of_nothing_that_its_own_sums_round_to_the_line() -> None:
    """Demands beyond the edge by powers of ten: some miss the line by last bits of sums over whole limits."""
    vehicle, rng = numbered(920)
    taus = edge_demands(vehicle, rng, 1000)
    F, status = build("redistribute@native", vehicle).many(taus)
    error = (np.abs(F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max(axis=1)
    assert np.count_nonzero(status == Status.SOLVED) > 300
    assert error[status == Status.SOLVED].max() <= 1e-9


@pytest.mark.parametrize("scalar", ["double", "float"])
def test_c_delivers_a_level_s_share_where_thrusters_are_stuck(scalar: Scalar) -> None:
    """Margins that a level used up were negative by rounding, and a later one passed them."""
    vehicle = load_vehicle("tiburon")
    demands = build_demands("jolts", vehicle, 0, 200)
    sides = [np.broadcast_to(side, (len(demands.taus), vehicle.n)) for side in demands.limits]
    allocate = build("priority", vehicle)
    answers = [allocate(tau, low, high) for tau, low, high in zip(demands.taus, *sides, strict=True)]
    kind = np.float32 if scalar == "float" else np.float64
    program = recipe("priority").make(vehicle, "call", scalar)
    got = evaluate(program, *(np.asarray(each, kind) for each in (demands.taus, *sides)))
    firsts = [
        (answer.share[0], share[0]) for answer, share in zip(answers, got.share, strict=True) if answer.found
    ]
    assert len(firsts) > 100
    np.testing.assert_allclose(*zip(*firsts, strict=True), rtol=0, atol=1e-3)


def spoiled_piece(*given: Any, far: float = 100.0) -> Piece:
    """A part of the kernel whose steps end so far [N] outside, at thrusts that make the same wrench."""
    part = piece(*given)
    block: Block = given[2]
    by = far * block.N[:, 0] / np.abs(block.N[:, 0]).max()

    def thrusts() -> dict[int, Expression]:
        return {i: x + float(by[block.rows.tolist().index(i)]) for i, x in part.thrusts().items()}

    return part._replace(thrusts=thrusts, gaps=None)


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize("method", ["scaled", "priority"])
def test_c_that_went_astray_says_a_smaller_share(
    method: str, scalar: Scalar, limits: Where, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(by_level, "piece", spoiled_piece)
    vehicle = load_vehicle("bluerov2-heavy")
    taus = edge_demands(vehicle, np.random.default_rng(3), 200)
    got = in_c(vehicle, method, scalar, limits, taus)
    says = promised(vehicle, method, taus, got.share)
    assert set(got.status.tolist()) == {Status.PARTIAL}
    assert ((vehicle.f_min <= got.F) & (vehicle.f_max >= got.F)).all()
    assert 0.0 < got.share.max() < 0.7
    error = np.abs(got.F @ vehicle.TP.T - says) / vehicle.wrench_scale
    assert error.max() <= (OFF if scalar == "double" else 1e-5)
    monkeypatch.setattr(
        by_level, "correct_thrusts", lambda _, __, thrusts, walk, *___: Correction(thrusts, walk.shares)
    )
    got = in_c(vehicle, method, scalar, limits, taus)
    error = np.abs(got.F @ vehicle.TP.T - promised(vehicle, method, taus, got.share)) / vehicle.wrench_scale
    assert error.max() > 0.1


@pytest.mark.parametrize("limits", ["fixed", "call"])
def test_c_that_ends_a_little_beyond_upper_limits_keeps_its_share_where_no_thruster_reverses(
    limits: Where, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At rest thrusts lie at lower limits; the room from there to these is nothing, and so was the share."""
    monkeypatch.setattr(by_level, "piece", partial(spoiled_piece, far=0.01))
    vehicle, rng = numbered(74)
    allocate = build("scaled", vehicle)
    asked = 1.5 * rng.uniform(10.0, vehicle.f_max, (400, vehicle.n)) @ vehicle.TP.T
    answers = [allocate(tau) for tau in asked]
    clear = [i for i, each in enumerate(answers) if each.status is Status.PARTIAL and each.f.min() > 0.1]
    got = in_c(vehicle, "scaled", "double", limits, asked[clear])
    share = np.array([answers[i].share for i in clear])
    assert len(clear) > 20
    assert (got.share < share).any()  # drawn in
    np.testing.assert_allclose(got.share, share, rtol=1e-3)


@pytest.mark.parametrize("apart", [1e-15, 5e-12, 1e-10])
@pytest.mark.parametrize("method", ["scaled-by-group", "priority"])
def test_c_takes_no_thrust_away_from_groups_that_last_digits_couple(method: str, apart: float) -> None:
    """Groups counted as apart up to 1e-9, and the second one's step took all thrusts of the first away."""
    shipped, rng = load_vehicle("bluerov2-heavy"), np.random.default_rng(4)
    vehicle = replace(shipped, T=shipped.T + apart * rng.uniform(-1.0, 1.0, shipped.T.shape))
    taus = edge_demands(vehicle, rng, 300)
    got = in_c(vehicle, method, "double", "fixed", taus)
    says = promised(vehicle, recipe(method).formulation, taus, got.share)
    error = np.abs(got.F @ vehicle.TP.T - says) / vehicle.wrench_scale
    assert error.max() <= OFF
