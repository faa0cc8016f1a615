"""An axis that is nearly lost takes no other with it, in Python and in C."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from alloc import Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.c import missing
from alloc.c.target import Target
from alloc.formulations import find_formulation
from alloc.methods import recipe
from alloc.program import Scalar, Where, at_fault, evaluate
from alloc.vehicle.weak import Survey
from bench.demands.store import pack_vehicle, unpack_vehicle
from bench.demands.surveys import fail_thrusters, hexarotor, move_poses, pushable_demands
from tests.readers import written

WITH_SHARE = ("scaled", "scaled-by-group", "priority")
LEAST = 0.95
"""Least part of what the drawing delivers that a survey of 3 mm, 0.3 deg may leave of it: the goal."""
DRAWINGS = {"bluerov2": load_vehicle("bluerov2"), "bluerov2-heavy": load_vehicle("bluerov2-heavy")}
DRAWINGS |= {"hexarotor": hexarotor()}
LOST = [("bluerov2", (1,)), ("bluerov2", (4, 5)), ("bluerov2-heavy", (4, 5)), ("bluerov2-heavy", (0, 3))]
LOST += [("hexarotor", (0, 3)), ("bluerov2-heavy", ()), ("hexarotor", (1,))]
cases = pytest.mark.parametrize(("name", "off"), LOST, ids=[f"{name}-{off}" for name, off in LOST])


def pair(name: str, off: tuple[int, ...], survey: Survey, number: int) -> tuple[Vehicle, Vehicle]:
    """A drawing and what a survey finds of it, with thrusters off."""
    found = move_poses(DRAWINGS[name], survey, np.random.default_rng(number))
    return fail_thrusters(DRAWINGS[name], off), fail_thrusters(replace(found, name=f"{name}-surveyed"), off)


def along(vehicle: Vehicle, F: FloatArray, taus: FloatArray) -> FloatArray:
    """(N,) share of each demand that thrusts make along it, moments in unit of the rms arm."""
    unit = vehicle.directions.scale
    made, wanted = F @ vehicle.TP.T / unit, taus / unit
    share: FloatArray = (made * wanted).sum(axis=1) / (wanted**2).sum(axis=1)
    return share


@cases
@pytest.mark.parametrize("method", WITH_SHARE[::2])
@pytest.mark.parametrize(
    "survey", [Survey(0.1, 0.01), Survey(0.5, 0.05), Survey()], ids=lambda one: one.words
)
def test_a_survey_costs_no_more_than_its_noise(
    name: str, off: tuple[int, ...], method: str, survey: Survey
) -> None:
    drawing, found = pair(name, off, survey, len(off))
    taus = pushable_demands(drawing, 60, np.random.default_rng(5))
    noise = np.radians(survey.deg) + survey.mm / 150.0  # of directions, and of arms of 15 cm
    least = 1.0 - 1.9 * noise
    assert least >= LEAST
    F, _ = build(method, found).many(taus)
    assert (found.f_min <= F).all()
    assert (found.f_max >= F).all()
    # What one level leaves may be anything to the next, on drawings too: the first level is compared.
    first = [np.array([build(method, vehicle)(tau).share[0] for tau in taus]) for vehicle in (drawing, found)]
    assert (first[1] >= least * first[0]).all()
    if method == "scaled":
        before = along(drawing, build(method, drawing).many(taus)[0], taus)
        assert (along(found, F, taus) >= least * before).all()


def test_the_surveyed_six_thruster_bluerov2_surges_and_dives() -> None:
    vehicle = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
    assert vehicle.weak_left == pytest.approx(0.00535, abs=5e-5)
    for method in WITH_SHARE:
        surge, heave = (build(method, vehicle)(tau) for tau in 30.0 * np.eye(6)[[0, 2]])
        assert surge.share == heave.share == (1.0,)
        assert (vehicle.T @ surge.f)[0] == pytest.approx(30.0, rel=0.003)  # and not 12 N
        assert np.abs(surge.f).max() < 11.0  # and not 40 N against each other
        assert (vehicle.T @ heave.f)[2] == pytest.approx(30.0, rel=0.001)
        assert np.abs(heave.f[:4]).max() < 0.1  # and not 16.7 N
        assert abs(heave.residual[4]) < 0.06


@pytest.mark.parametrize("method", WITH_SHARE)
def test_a_demand_along_a_weak_axis_costs_the_others_next_to_nothing(method: str) -> None:
    """A pitch of millimetres counted as 0.24 of an arm: 5 N m of it made -13 N of surge."""
    vehicle = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
    allocate = build(method, vehicle)
    alone, both = (allocate(tau) for tau in ([0, 0, 0, 0, 5, 0], [30, 0, 0, 0, 5, 0]))
    assert np.abs(vehicle.T[:3] @ alone.f).max() < 1.1
    assert (vehicle.T @ both.f)[0] == pytest.approx(30.0, abs=1.2)


@pytest.mark.parametrize("dof", [["surge", "pitch", "yaw"], ["surge", "pitch"]], ids="-".join)
def test_poses_tell_of_axes_that_nobody_controls(dof: list[str], tmp_path: Path) -> None:
    """No column of surge, pitch and yaw alone was a thrust along a line; thrusters fought each other."""
    text = Path("docs/vehicles/bluerov2-surveyed.yaml").read_text(encoding="utf-8")
    whole = "[surge, sway, heave, roll, pitch, yaw]"
    vehicle = load_vehicle(written(tmp_path / "mine.yaml", text.replace(whole, f"[{', '.join(dof)}]")))
    for one in (vehicle, vehicle.with_frame("frd"), unpack_vehicle(pack_vehicle(vehicle))):
        assert len(one.weak) == 1
        surge = build("scaled", one)(30.0 * np.eye(len(dof))[0])
        assert surge.share == (1.0,)
        assert (one.T @ surge.f)[0] == pytest.approx(30.0, rel=0.03)
        assert np.abs(surge.f).max() < 11.0  # and not 50 N against 40


@cases
@pytest.mark.parametrize("method", WITH_SHARE)
def test_residual_is_what_thrusts_make_along_weak_directions(
    name: str, off: tuple[int, ...], method: str
) -> None:
    drawing, vehicle = pair(name, off, Survey(), 3)
    far = np.maximum(np.abs(vehicle.f_min), vehicle.f_max)
    rows, unit = vehicle.weak, vehicle.directions.scale
    for tau in pushable_demands(drawing, 10, np.random.default_rng(6)):
        answer = build(method, vehicle)(tau)
        across = answer.residual / unit - (rows * unit).T @ (rows @ answer.residual)
        np.testing.assert_allclose(across, 0.0, atol=1e-7 * vehicle.f_scale)
        assert (np.abs(rows @ answer.residual) <= np.abs(rows @ vehicle.TP) @ far + 1e-7).all()
        way = find_formulation(method).way
        assert way is not None
        through = way(vehicle)
        begin = through.departure(vehicle.f_min, vehicle.f_max)
        promised = through.delivered(tau[None], begin, np.array([answer.share]))[0]
        np.testing.assert_allclose(
            vehicle.TP @ answer.f - promised, answer.residual, atol=1e-7 * vehicle.f_scale
        )


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_drawing_has_the_answers_and_programs_of_one_that_leaves_nothing_out(name: str) -> None:
    drawing = DRAWINGS[name]
    never = replace(drawing, weak_limit=0.0)
    taus = pushable_demands(drawing, 40, np.random.default_rng(8))
    for method in WITH_SHARE:
        np.testing.assert_array_equal(
            build(method, drawing).many(taus)[0], build(method, never).many(taus)[0]
        )
        assert not build(method, drawing)(taus[0]).residual.any()
        ours, theirs = (recipe(method).program_for_all(each, "call") for each in (drawing, never))
        assert (ours.nodes, ours.steps, ours.outputs) == (theirs.nodes, theirs.steps, theirs.outputs)


@cases
@pytest.mark.parametrize(("scalar", "error"), [("double", 1e-9), ("float", 2e-3)])
def test_c_for_all_faults_answers_as_python_does(
    name: str, off: tuple[int, ...], scalar: Scalar, error: float
) -> None:
    drawing, vehicle = pair(name, off[:-1], Survey(), 4)
    made = Target(
        vehicle=vehicle, method=recipe("scaled"), scalar=scalar, limits="call", faults="all"
    ).programs
    fault = off[-1] if off else -1
    degraded = vehicle if fault < 0 else vehicle.with_fault(fault)
    taus = pushable_demands(drawing if fault < 0 else drawing.with_fault(fault), 30, np.random.default_rng(9))
    own = [np.tile(side, (len(taus), 1)) for side in (degraded.f_min, degraded.f_max)]
    one = made[fault]
    got = evaluate(at_fault(one, fault) if one.faults else one, taus, *own)
    F, _ = build("scaled", degraded).many(taus)
    shares = [build("scaled", degraded)(tau).share for tau in taus]
    np.testing.assert_allclose(got.share, shares, atol=error)
    np.testing.assert_allclose(got.F, F, atol=10 * error * vehicle.f_scale)


DIVES = [("bluerov2-heavy", off) for off in ((4, 5), (5, 6), (6, 7), (4,), ())] + [("hexarotor", (0, 3))]


@pytest.mark.parametrize(("name", "off"), DIVES, ids=[f"{name}-{off}" for name, off in DIVES])
@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize("scalar", ["float", "double"])
def test_c_of_several_levels_gives_as_much_as_python_does(
    name: str, off: tuple[int, ...], limits: Where, scalar: Scalar
) -> None:
    """Float gave nothing on 11 of 400 demands: thin rows of N magnify rounding, which counted as a miss."""
    for number, survey in ((0, Survey(0.5, 0.05)), (1, Survey())):
        drawing, vehicle = pair(name, off, survey, number)
        if name == "hexarotor":
            vehicle = replace(vehicle, priority=(("roll", "pitch"), ("heave",), ("yaw",)))
        taus = pushable_demands(drawing, 400, np.random.default_rng(5))
        program = Target(
            vehicle=vehicle, method=recipe("priority"), scalar=scalar, limits=limits, faults="none"
        ).programs[-1]
        ends = limits_of_calls(vehicle, len(taus)) if limits == "call" else ()
        got = evaluate(program, taus, *ends)
        one_by_one = build("priority", vehicle)
        calls = zip(taus, *ends, strict=True) if ends else ((tau,) for tau in taus)
        shares = np.array([one_by_one(*call).share for call in calls])
        assert (got.share >= shares - 0.01).all()
        low, high = ends or (vehicle.f_min, vehicle.f_max)
        kind = np.float32 if scalar == "float" else np.float64
        assert ((kind(low) <= got.F) & (kind(high) >= got.F)).all()


def limits_of_calls(vehicle: Vehicle, count: int) -> tuple[FloatArray, FloatArray]:
    """(count, n) limits of calls, two in three of them narrower than the vehicle's."""
    low, high = (np.tile(side, (count, 1)) for side in (vehicle.f_min, vehicle.f_max))
    ends = np.sort(np.random.default_rng(3).uniform(low, high, (2, *low.shape)), axis=0)
    narrow = np.arange(count) % 3 > 0
    low[narrow], high[narrow] = ends[0, narrow], ends[1, narrow]
    return low, high


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@pytest.mark.parametrize("form", ["library", "native"])
@pytest.mark.parametrize("off", [(4, 5), (0, 3)])
def test_compiled_allocators_leave_out_the_same_and_state_what_is_left(
    off: tuple[int, ...], form: str
) -> None:
    drawing, vehicle = pair("bluerov2-heavy", off, Survey(), 3)
    compare(vehicle, form, pushable_demands(drawing, 20, np.random.default_rng(6)))


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@pytest.mark.parametrize("form", ["library", "native"])
def test_compiled_allocators_count_a_short_row_by_the_same_length(form: str) -> None:
    """The library took its own length, a pitch of millimetres: surge 30 N gave 16 N, with a pitch -70 N."""
    vehicle = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
    taus = [[30, 0, 0, 0, 0, 0], [30, 0, 0, 0, 2, 0], [0, 0, 0, 0, 5, 0], [80, 9, 20, 1, 0, 2]]
    compare(vehicle, form, taus)


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@pytest.mark.parametrize("off", [4, 5])
def test_the_library_leaves_out_nothing_that_a_vehicle_keeps(off: int) -> None:
    """A failure that takes a direction made ``weak: 0`` the survey's, and pitch was left out."""
    vehicle = replace(load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml")), weak_limit=0.0)
    degraded = replace(vehicle, name="bluerov2-whole").with_fault(off)
    assert degraded.rank < degraded.k
    compare(degraded, "library", [[30, 0, 0, 0, 0, 0], [0, 0, 20, 0, 0, 0]])


def compare(vehicle: Vehicle, form: str, taus: Iterable[ArrayLike]) -> None:
    """Assert that a compiled ``scaled`` answers each demand as Python's does."""
    ours, theirs = build("scaled", vehicle), build(f"scaled@{form}", vehicle)
    for tau in taus:
        one, other = ours(tau), theirs(tau)
        np.testing.assert_allclose(other.share, one.share, atol=1e-8)
        np.testing.assert_allclose(other.f, one.f, atol=1e-6 * vehicle.f_scale)
        np.testing.assert_allclose(other.residual, one.residual, atol=1e-6 * vehicle.f_scale)


def test_hard_methods_keep_eq_5_to_the_letter() -> None:
    _, vehicle = pair("bluerov2-heavy", (4, 5), Survey(), 2)
    heave = 40.0 * np.eye(6)[2]
    assert build("nullspace", vehicle)(heave).status is Status.INFEASIBLE
    assert build("scaled", vehicle)(heave).share == (1.0,)
    assert build("scaled", replace(vehicle, weak_limit=0.0))(heave).share[0] < 0.1
