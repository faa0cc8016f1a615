"""Between weak and strong a direction counts in part: no share has a step in sigma, in Python and in C."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.allocation import Allocation, FloatArray
from alloc.c import missing
from alloc.c.target import Target
from alloc.formulations import find_formulation
from alloc.kernels.tolerance import SINGLE, WRENCH_ERROR
from alloc.methods import recipe
from alloc.program import Scalar, Where, at_fault, evaluate
from alloc.vehicle.condition import condition
from alloc.vehicle.weak import WEAK, Survey, doubts
from bench.demands import labelled
from bench.demands.surveys import fail_thrusters, hexarotor, move_poses, pushable_demands
from bench.judging.judge import judge
from bench.judging.question import ask_here, questions

WITH_SHARE = ("scaled", "scaled-by-group", "priority")
SURVEYED = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
OFF = {"bluerov2-heavy": (4, 5), "hexarotor": (0, 3)}
FAR = Survey(20.0, 2.3)
"""Errors of a survey that leave a lost direction enough for single precision: a condition of 35 or less."""
names = pytest.mark.parametrize("name", ["bluerov2", *OFF])


def surveyed(name: str) -> Vehicle:
    """A vehicle with a direction that its drawing lost, as a survey finds it."""
    if name == "bluerov2":
        return SURVEYED
    drawing = hexarotor() if name == "hexarotor" else load_vehicle(name)
    return fail_thrusters(move_poses(drawing, FAR, np.random.default_rng(3)), OFF[name])


def at(vehicle: Vehicle, ratio: float) -> Vehicle:
    """The vehicle with a survey by which the least sigma / epsilon is so much."""
    found = vehicle.directions
    by = float((found.sigma / found.epsilon).min()) / ratio
    survey = Survey(by * vehicle.survey.mm, by * vehicle.survey.deg)
    return replace(vehicle, survey=survey, name=f"{vehicle.name}-{100 * ratio:.0f}")


def demands(vehicle: Vehicle, count: int = 30) -> FloatArray:
    """Demands (count, k) along what is strong and what is weak, beyond the limits too."""
    return pushable_demands(vehicle, count, np.random.default_rng(5))


@names
@pytest.mark.parametrize("method", WITH_SHARE)
def test_answers_go_straight_from_the_weak_one_to_the_strong_one(name: str, method: str) -> None:
    """Thrusts, shares and residuals; at 2 and 4 epsilon they are those of either side, so nothing steps."""
    vehicle = surveyed(name)
    taus = demands(vehicle)
    low, high = at(vehicle, 0.999 * WEAK), at(vehicle, 2.001 * WEAK)
    assert high.strong is high
    for tau in taus:
        weak, strong = (build(method, one)(tau) for one in (low, high))
        for ratio in (1.0001 * WEAK, 1.25 * WEAK, 1.5 * WEAK, 1.9999 * WEAK):
            one = at(vehicle, ratio)
            w = ratio / WEAK - 1.0
            assert one.counts[-1] == pytest.approx(w)
            found = build(method, one)(tau)
            for key in ("f", "share", "residual"):
                ours, past, ahead = (np.asarray(getattr(each, key)) for each in (found, weak, strong))
                np.testing.assert_allclose(ours, past + w * (ahead - past), atol=1e-7 * vehicle.f_scale)
            assert ((vehicle.f_min <= found.f) & (found.f <= vehicle.f_max)).all()
            solved = weak.status is strong.status is Status.SOLVED
            assert found.status is (Status.SOLVED if solved else Status.PARTIAL)


@pytest.mark.parametrize("cap", [None, 20.0])
def test_least_currents_go_straight_from_the_weak_one_to_the_strong_one(cap: float | None) -> None:
    """The program of all directions was asked from 2 epsilon on: 13 N and 0.07 of a share at one step."""
    vehicle, answers = surveyed("bluerov2-heavy"), dict[float, list[Allocation]]()
    for ratio in (0.999, 1.0001, 1.4, 1.9999, 2.001):
        one = at(vehicle, ratio * WEAK)
        frugal = build("frugal", one)
        answers[ratio] = [frugal(tau, cap=cap, volts=14.8) for tau in demands(vehicle, 12)]
        for answer in answers[ratio]:
            assert ((vehicle.f_min <= answer.f) & (answer.f <= vehicle.f_max)).all()
            assert cap is None or np.sum(answer.amps) <= cap
            np.testing.assert_array_equal(answer.amps, one.draw(14.8).amps(answer.f))
    for ratio in (1.0001, 1.4, 1.9999):
        for weak, found, strong in zip(answers[0.999], answers[ratio], answers[2.001], strict=True):
            for key in ("f", "share", "residual"):
                ours, past, ahead = (np.asarray(getattr(each, key)) for each in (found, weak, strong))
                expected = past + (ratio - 1.0) * (ahead - past)
                np.testing.assert_allclose(ours, expected, atol=1e-6 * vehicle.f_scale)


@pytest.mark.parametrize("method", WITH_SHARE)
def test_a_share_has_no_step_where_poses_move_a_direction_through_the_band(method: str) -> None:
    """Just above twice its error pitch counted wholly, and surge 60 fell from 54 N to 12."""
    assert SURVEYED.poses is not None
    taus = np.vstack([60.0 * np.eye(6)[0], demands(SURVEYED, 5)])
    before: tuple[FloatArray, float] | None = None
    for times in np.linspace(3.9, 8.3, 221):
        poses = SURVEYED.poses * np.array([1, 1, 1, 1, times, 1])[:, None]
        vehicle = replace(SURVEYED, T=poses, poses=poses)
        allocate = build(method, vehicle)
        shares = np.array([allocate(tau).share[0] for tau in taus])
        ratio = float((vehicle.directions.sigma / vehicle.directions.epsilon).min()) / WEAK
        if before is not None:  # each moves sigma by 0.005 of 2 epsilon
            assert np.abs(shares - before[0]).max() <= 2.0 * (ratio - before[1])
        before = shares, ratio
    assert before is not None
    assert before[1] > 2.0


def test_several_directions_count_each_by_its_own_share() -> None:
    """Two that count in part make three answers, the one with the larger share first."""
    vehicle = fail_thrusters(move_poses(load_vehicle("subjugator8"), FAR, np.random.default_rng(3)), (1, 6))
    sigma = vehicle.directions.sigma / vehicle.directions.sigma[0]
    vehicle = replace(vehicle, weak_limit=float(sigma[-2]) / 1.8)
    between = vehicle.counts[(vehicle.counts > 0.0) & (vehicle.counts < 1.0)]
    ws = [w for w, _ in vehicle.mixture]
    assert ws == [1.0, *sorted(between, reverse=True)]
    ranks = [one.rank for _, one in vehicle.mixture]
    assert ranks == list(range(ranks[0], ranks[0] + len(ws)))
    assert vehicle.mixture[-1][1] is vehicle.strong


@names
@pytest.mark.parametrize("method", WITH_SHARE)
@pytest.mark.parametrize(("scalar", "error"), [("double", 1e-9), ("float", 2e-3)])
@pytest.mark.parametrize("limits", ["fixed", "call"])
def test_c_mixes_as_python_does(name: str, method: str, scalar: Scalar, error: float, limits: Where) -> None:
    vehicle = at(surveyed(name), 1.4 * WEAK)
    taus, allocate = demands(vehicle), build(method, vehicle)
    target = Target(vehicle=vehicle, method=recipe(method), scalar=scalar, limits=limits, faults="none")
    ends = [np.tile(side, (len(taus), 1)) for side in (0.7 * vehicle.f_min, 0.5 * vehicle.f_max)]
    ends = ends if limits == "call" else []
    got = evaluate(target.programs[-1], taus, *ends)
    answers = [allocate(tau, *(side[0] for side in ends)) for tau in taus]
    np.testing.assert_allclose(got.share, [one.share for one in answers], atol=error)
    np.testing.assert_allclose(got.F, [one.f for one in answers], atol=10 * error * vehicle.f_scale)
    assert (got.status == [one.status for one in answers]).all()
    F, status = allocate.many(taus, *ends)
    np.testing.assert_allclose(F, [one.f for one in answers], atol=1e-9 * vehicle.f_scale)
    assert (status == [one.status for one in answers]).all()


@pytest.mark.parametrize("method", ["scaled", "priority"])
def test_single_precision_costs_a_mixture_w_of_what_it_costs_the_answer_of_all(method: str) -> None:
    found = move_poses(hexarotor(), Survey(6.0, 0.6), np.random.default_rng(5))
    found = fail_thrusters(found, OFF["hexarotor"])
    worst, half = condition(found), WRENCH_ERROR["float"] / 4 / SINGLE / condition(found)
    assert 0.5 < half < 0.9
    for w in (0.1, 0.5, 0.98 * half):
        vehicle = at(found, (1.0 + w) * WEAK)
        taus = demands(vehicle, 200)
        one, other = (
            evaluate(
                Target(vehicle=vehicle, method=recipe(method), scalar=scalar, faults="none").programs[-1],
                taus,
            )
            for scalar in ("float", "double")
        )
        missed = np.abs((one.F - other.F) @ vehicle.TP.T / vehicle.wrench_scale).max()
        assert missed <= SINGLE * (w * worst + vehicle.n)
        assert (one.status == other.status).all()
    vehicle = at(found, (1.02 + half) * WEAK)
    with pytest.raises(NotApplicable, match="single precision"):
        recipe(method).program(vehicle, "fixed", "float")


def test_c_for_all_faults_mixes_where_a_failure_makes_a_direction_count_in_part() -> None:
    whole = move_poses(load_vehicle("bluerov2-heavy"), Survey(), np.random.default_rng(3)).with_fault(4)
    vehicle = replace(whole, survey=at(whole.with_fault(5), 1.5 * WEAK).survey)
    assert len(vehicle.mixture) == 1
    made = Target(vehicle=vehicle, method=recipe("scaled"), limits="call", faults="all").programs
    degraded = vehicle.with_fault(5)
    assert len(degraded.mixture) == 2
    taus = demands(degraded)
    own = [np.tile(side, (len(taus), 1)) for side in (degraded.f_min, degraded.f_max)]
    got = evaluate(at_fault(made[5], 5) if made[5].faults else made[5], taus, *own)
    np.testing.assert_allclose(got.F, build("scaled", degraded).many(taus)[0], atol=1e-8 * vehicle.f_scale)


Answered = tuple[FloatArray, FloatArray]
"""Thrusts (N, n) and shares (N, L); of ``many`` no shares."""


def called(method: str, vehicle: Vehicle, taus: FloatArray) -> Answered:
    answers = [build(method, vehicle)(tau) for tau in taus]
    return np.array([one.f for one in answers]), np.array([one.share for one in answers])


def together(method: str, vehicle: Vehicle, taus: FloatArray) -> Answered:
    F, _ = build(method, vehicle).many(taus)
    return F, np.zeros((len(taus), 0))


def in_c(method: str, vehicle: Vehicle, taus: FloatArray, scalar: Scalar) -> Answered:
    target = Target(vehicle=vehicle, method=recipe(method), scalar=scalar, faults="none")
    got = evaluate(target.programs[-1], taus)
    return got.F, got.share


def by_library(method: str, vehicle: Vehicle, taus: FloatArray) -> Answered:
    return called(f"{method}@library", vehicle, taus)


FORMS: dict[str, tuple[Callable[[str, Vehicle, FloatArray], Answered], float]] = {
    "call": (called, 0.0),
    "many": (together, 1e-9),
    "double": (partial(in_c, scalar="double"), 1e-8),
    "float": (partial(in_c, scalar="float"), 2e-3),
    "library": (by_library, 1e-7),
}
"""The forms of a method, and how far each may be from Python's call: of a share, and of the largest limit."""


@names
@pytest.mark.parametrize("method", WITH_SHARE)
def test_all_forms_give_one_answer_that_a_survey_moves_by_no_more_than_its_noise(
    name: str, method: str
) -> None:
    """From 2 to 4 epsilon w goes from 0 to 1: shares change by no more than w, thrusts by that of a width.

    A survey's noise moves sigma by epsilon, and w by half: no share differs by more than half of the noise.
    """
    found, before = surveyed(name), dict[str, Answered]()
    taus = demands(found, 5)
    ratios = np.array([1.9, 1.99, 2.01, 2.5, 3.2, 3.99, 4.01, 4.2])
    w = np.clip(ratios / WEAK - 1.0, 0.0, 1.0)
    left_out = {"library"} if missing() or method == "scaled-by-group" else set()
    for i, ratio in enumerate(ratios.tolist()):
        vehicle = at(found, ratio)
        for form in (form for form in FORMS if form not in left_out):
            answer, error = FORMS[form]
            F, share = answer(method, vehicle, taus)
            for ours, theirs, width in zip(
                (F, share), before.get(form, ()), (2 * vehicle.f_scale, 1.0), strict=False
            ):
                assert np.abs(ours - theirs).max(initial=0.0) <= width * (w[i] - w[i - 1] + 2 * error + 1e-9)
            before[form] = F, share
            for ours, theirs, width in zip((F, share), before["call"], (vehicle.f_scale, 1.0), strict=True):
                if ours.size:
                    assert np.abs(ours - theirs).max() <= width * error, (form, ratio)


def coupled(times: float) -> Vehicle:
    """A drawing whose thruster 0 heaves too, by so many times what its survey may make of nothing."""
    vehicle = load_vehicle("bluerov2-heavy")
    e = np.sqrt(doubts(vehicle.T, vehicle.dof, vehicle.survey, np.eye(vehicle.k)))[2, 0]
    T = vehicle.T.copy()
    T[2, 0] = times * e
    return replace(vehicle, T=T, name=f"{vehicle.name}-{1000 * times:.0f}")


def test_groups_of_axes_pass_from_apart_to_together_without_a_step() -> None:
    """Noise of millimetres made all axes one group: a yaw that saturated took the heave along."""
    drawing = load_vehicle("bluerov2-heavy")
    taus = np.vstack([demands(drawing, 12), [200, 0, 60, 0, 0, 90]])
    method, before = "scaled-by-group", np.zeros(0)
    for times in np.linspace(0.0, 4.4, 111):
        F, _ = build(method, coupled(times)).many(taus)
        if before.size:  # each moves w by 0.04 at most, and thrusts by so much of their widths
            assert np.abs(F - before).max() <= 0.04 * 2.0 * drawing.f_scale
        before = F
    assert len(find_formulation(method).parts(coupled(2.9))) == 1
    assert len(find_formulation(method).parts(coupled(3.5))) == 2
    assert len(find_formulation(method).parts(coupled(4.1))[0].way.levels) == 1


@pytest.mark.parametrize(("scalar", "error"), [("double", 1e-9), ("float", 2e-3)])
def test_c_mixes_groups_as_python_does(scalar: Scalar, error: float) -> None:
    vehicle = coupled(3.4)
    taus, allocate = demands(vehicle), build("scaled-by-group", vehicle)
    method = recipe("scaled-by-group")
    for faults in ("none", "all"):
        target = Target(vehicle=vehicle, method=method, scalar=scalar, limits="call", faults=faults)
        ends = [np.tile(side, (len(taus), 1)) for side in (0.7 * vehicle.f_min, 0.5 * vehicle.f_max)]
        program = target.programs[-1]
        got = evaluate(at_fault(program, -1) if program.faults else program, taus, *ends)
        answers = [allocate(tau, *(side[0] for side in ends)) for tau in taus]
        np.testing.assert_allclose(got.share, [one.share for one in answers], atol=error)
        np.testing.assert_allclose(got.F, [one.f for one in answers], atol=10 * error * vehicle.f_scale)
    (question,) = questions([asked := labelled("any", vehicle, taus)], ask_here, {"scaled-by-group"})
    found = judge(
        question,
        [allocate(tau) for tau in asked.taus],
        formulation="scaled-by-group",
        limited=True,
        tolerance=allocate.tolerance,
    )
    assert (found.wrong, found.agrees) == ("", True)


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@names
@pytest.mark.parametrize(
    "compiled", [f"{name}@native" for name in WITH_SHARE] + ["scaled@library", "priority@library"]
)
def test_compiled_c_states_what_is_left_along_such_a_direction(name: str, compiled: str) -> None:
    vehicle = at(surveyed(name), 1.4 * WEAK)
    ours, theirs = build(compiled.partition("@")[0], vehicle), build(compiled, vehicle)
    narrow = 0.7 * vehicle.f_min, 0.5 * vehicle.f_max
    for tau in demands(vehicle, 10):
        for one, other in ((ours(tau), theirs(tau)), (ours(tau, *narrow), theirs(tau, *narrow))):
            assert other.status is one.status
            for key in ("f", "share", "residual"):
                np.testing.assert_allclose(
                    getattr(other, key), getattr(one, key), atol=1e-8 * vehicle.f_scale
                )


@names
@pytest.mark.parametrize("method", WITH_SHARE)
def test_the_judge_agrees_with_what_is_promised(name: str, method: str) -> None:
    vehicle = at(surveyed(name), 1.4 * WEAK)
    asked = labelled("any", vehicle, demands(vehicle))
    (question,) = questions([asked], ask_here, {method})
    allocate = build(method, vehicle)
    answers = [allocate(tau) for tau in asked.taus]
    found = judge(question, answers, formulation=method, limited=True, tolerance=allocate.tolerance)
    assert found.wrong == ""
    assert found.agrees is not False
    assert (asked.alpha[[one.status is Status.SOLVED for one in answers]] >= 1.0 - 1e-6).all()
    broken = [one._replace(share=tuple(0.9 * part for part in one.share)) for one in answers]
    wrong = judge(question, broken, formulation=method, limited=True, tolerance=allocate.tolerance).wrong
    assert "shares of its levels" in wrong
