"""libthrustbench leaves out the same weak directions as Python, decided at boot and at each failure."""

import ctypes
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, build, load_vehicle
from alloc.vehicle.weak import WEAK, Survey
from bench.demands.surveys import fail_thrusters, failures, hexarotor, move_poses, pushable_demands
from tests.library import Allocator, survey_of
from tests.readers import written

CLOSE = 1e-7
"""Share of the largest limit: a direction that is all but lost magnifies what differs in T."""


def surveyed(name: str) -> Vehicle:
    """A drawing as a tape measure finds it."""
    drawing = hexarotor() if name == "hexarotor" else load_vehicle(name)
    levels = (("roll", "pitch"), ("heave",), ("yaw",)) if name == "hexarotor" else drawing.priority
    return replace(move_poses(drawing, Survey(), np.random.default_rng(3)), priority=levels)


def compare(
    vehicle: Vehicle, off: tuple[int, ...], library: Allocator, method: str, *, wrenches: bool = False
) -> None:
    """Assert that the library answers as Python does without these thrusters, or that its wrenches are."""
    degraded = fail_thrusters(vehicle, off)
    python = build(method, degraded)
    for tau in pushable_demands(degraded, 6, np.random.default_rng(4)):
        one = python(tau)
        status, f, share = library(method, tau)
        assert status == one.status
        np.testing.assert_allclose(share, one.share, rtol=0, atol=CLOSE)
        seen = vehicle.TP if wrenches else np.eye(vehicle.n)
        np.testing.assert_allclose(seen @ f, seen @ one.f, rtol=0, atol=CLOSE * vehicle.f_scale)


@pytest.mark.parametrize("method", ["scaled", "priority"])
@pytest.mark.parametrize("name", ["bluerov2", "bluerov2-heavy", "hexarotor"])
def test_each_failure_leaves_out_what_python_leaves_out(name: str, method: str) -> None:
    vehicle = surveyed(name)
    survey, library, weak = survey_of(vehicle), Allocator(vehicle), 0
    for off in failures(vehicle, 2):
        assert library.strong(survey[0], *off) == 0
        weak += fail_thrusters(vehicle, off).strong.units is not None
        compare(vehicle, off, library, method)
    assert weak >= 3
    assert library.strong(survey[0]) == 0  # all are back
    compare(vehicle, (), library, method)


@pytest.mark.parametrize(
    "change",
    [
        lambda vehicle: replace(vehicle, survey=Survey(relative=0.02)),
        lambda vehicle: replace(vehicle, weak_limit=0.03),
        lambda vehicle: replace(
            vehicle, T=vehicle.T * 50, f_min=vehicle.f_min / 50, f_max=vehicle.f_max / 50
        ),
        lambda vehicle: replace(vehicle, readiness=np.array([1, 1, 0.5, 1, 1, 1, 0.3, 1])),
    ],
    ids=["relative", "share", "unit", "weakened"],
)
def test_tolerances_and_units_count_as_in_python(change: Callable[[Vehicle], Vehicle]) -> None:
    vehicle = change(surveyed("bluerov2-heavy"))
    vehicle = replace(vehicle, poses=None)
    library, survey = Allocator(vehicle), survey_of(vehicle)
    for off in ((4, 5), (0, 3), (2,)):
        assert library.strong(survey[0], *off) == 0
        compare(vehicle, off, library, "scaled")


def test_poses_tell_of_axes_that_nobody_controls(tmp_path: Path) -> None:
    text = Path("docs/vehicles/bluerov2-surveyed.yaml").read_text(encoding="utf-8")
    axes = text.replace("[surge, sway, heave, roll, pitch, yaw]", "[surge, pitch, yaw]")
    vehicle = load_vehicle(written(tmp_path / "mine.yaml", axes))
    library, (survey, _kept) = Allocator(vehicle), survey_of(vehicle)
    assert library.strong(survey) == 0
    # One newton of a vertical thruster moves a horizontal one by 5e-7 N: rounding tells them apart.
    compare(vehicle, (), library, "scaled", wrenches=True)
    assert np.abs(library("scaled", np.array([30.0, 0.0, 0.0]))[1]).max() < 11.0  # and not 50 N against 40
    survey.poses = None
    assert library.strong(survey) == 0
    assert np.abs(library("scaled", np.array([30.0, 0.0, 0.0]))[1]).max() > 49.0


def test_without_a_survey_and_without_weak_directions_it_is_tb_without() -> None:
    drawing = load_vehicle("bluerov2-heavy")
    survey, one, other = survey_of(drawing), Allocator(drawing), Allocator(drawing)
    for given in (None, survey[0]):
        for off in failures(drawing, 2):
            assert one.strong(given, *off) == other.without(*off) == 0
            tau = pushable_demands(drawing, 1, np.random.default_rng(1))[0]
            np.testing.assert_array_equal(one("scaled", tau)[1], other("scaled", tau)[1])
    assert one.strong(survey[0], 8) == -1
    assert one("scaled", np.zeros(6))[0] == -3


def test_tb_without_counts_what_a_survey_calls_weak_wholly_and_no_room_steps() -> None:
    vehicle = surveyed("bluerov2-heavy")
    library, (survey, _kept) = Allocator(vehicle), survey_of(vehicle)
    never = replace(vehicle, weak_limit=0.0)
    for off in ((4, 5), (0, 3)):
        assert len(fail_thrusters(vehicle, off).weak) == 1
        assert library.without(*off) == 0
        compare(never, off, library, "scaled", wrenches=True)
    degraded, survey.room = fail_thrusters(vehicle, (4, 5)), 0
    sigma = degraded.directions.sigma[-1] / degraded.directions.sigma[0]
    for limit, like in ((1.001 * sigma, vehicle), (0.999 * sigma, never)):  # a step, where there is no room
        survey.weak = limit
        assert library.strong(survey, 4, 5) == 0
        compare(replace(like, weak_limit=1.1 * sigma if like is vehicle else 0.0), (4, 5), library, "scaled")


@pytest.mark.parametrize(
    ("key", "value"),
    [("mm", -1.0), ("deg", np.nan), ("relative", np.inf), ("weak", 0.6), ("T", None), ("axis", None)],
)
def test_behind_what_is_no_survey_calls_refuse_until_thrusters_are_known_again(
    key: str, value: float | None
) -> None:
    vehicle = surveyed("bluerov2-heavy")
    library, (survey, _kept) = Allocator(vehicle), survey_of(vehicle)
    setattr(survey, key, value)
    assert library.strong(survey, 0) == -3
    assert library("scaled", np.ones(6))[0] == -3  # or thruster 0 would go on pushing
    assert library.without(0) == 0
    assert library("scaled", np.ones(6))[1][0] == 0.0


def test_axes_that_are_none_or_twice_there_and_a_survey_that_knows_nothing_are_refused() -> None:
    vehicle = surveyed("bluerov2-heavy")
    library, (survey, _kept) = Allocator(vehicle), survey_of(vehicle)
    for axes in ((0, 1, 2, 3, 4, 4), (0, 1, 2, 3, 4, 6), (-1, 1, 2, 3, 4, 5)):
        known = (ctypes.c_int * 6)(*axes)
        survey.axis = ctypes.cast(known, ctypes.c_void_p)
        assert library.strong(survey) == -3
    survey, _kept = survey_of(replace(vehicle, survey=Survey(relative=5.0)))
    assert library.strong(survey) == -3
    assert library("scaled", np.ones(6))[0] == -3
    assert library.strong(survey, 0) == 0  # a failure that leaves nothing strong is an ordinary one


@pytest.mark.parametrize("method", ["scaled", "priority"])
def test_a_share_has_no_step_where_a_direction_passes_from_weak_to_strong(method: str) -> None:
    """Surge 60 fell from 54 N to 12 where pitch counted wholly from twice its error on."""
    found = load_vehicle(Path("docs/vehicles/bluerov2-surveyed.yaml"))
    assert found.poses is not None
    taus = np.vstack([60.0 * np.eye(6)[0], pushable_demands(found, 5, np.random.default_rng(5))])
    before, least, in_part = np.zeros(0), 0.0, 0
    for times in np.linspace(3.9, 8.3, 111):
        poses = np.ascontiguousarray(found.poses * np.array([1, 1, 1, 1, times, 1])[:, None])
        vehicle = replace(found, T=poses, poses=poses)
        library, (survey, _kept) = Allocator(vehicle), survey_of(vehicle)
        assert library.strong(survey) == 0
        shares = np.array([library(method, tau)[2][0] for tau in taus])
        ratio = float((vehicle.directions.sigma / vehicle.directions.epsilon).min()) / WEAK
        if before.size:
            assert np.abs(shares - before).max() <= 2.0 * (ratio - least)
        before, least = shares, ratio
        in_part += len(vehicle.mixture) > 1
        compare(vehicle, (), library, method)
    assert least > 2.0
    assert in_part > 40


def test_each_direction_beyond_the_room_counts_wholly_and_levels_are_those_of_all_parts() -> None:
    found = load_vehicle("subjugator8")
    vehicle = fail_thrusters(move_poses(found, Survey(20.0, 2.3), np.random.default_rng(3)), (1, 6))
    sigma = vehicle.directions.sigma / vehicle.directions.sigma[0]
    vehicle = replace(vehicle, weak_limit=float(sigma[-2]) / 1.8)
    assert len(vehicle.mixture) == 3
    library, (survey, _kept) = Allocator(vehicle), survey_of(vehicle)
    assert library.strong(survey) == 0
    compare(vehicle, (), library, "scaled")
    survey.room = 0
    strong = replace(vehicle, weak_limit=float(sigma[-1]) / 2.1)
    assert library.strong(survey) == 0
    compare(strong, (), library, "scaled")
    survey.room = -1
    assert library.strong(survey) == -3
    levels = (("roll", "pitch", "yaw"), ("surge", "sway", "heave"))
    survey.room = 5
    assert library.strong(survey) == 0
    of = [next(i for i, axes in enumerate(levels) if axis in axes) for axis in vehicle.dof]
    assert library.levels((ctypes.c_int * 6)(*of)) == 0
    library.vehicle = replace(vehicle, priority=levels)
    compare(library.vehicle, (), library, "priority")
