"""The programs in docs/at-boot compile without a warning, run, and get Python's thrusts."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from alloc import Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.library import files
from alloc.program import Scalar
from tests.compilers import WARNINGS, needs, run, write
from tests.places import ROOT

PLACE = ROOT / "docs" / "at-boot"
LENIENT = ["-Wno-conversion", "-Wno-sign-conversion"]
"""Indices into std::array and std::vector are unsigned, and programs to be read are better without casts."""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Scalar], Path]:
    """The folder of the library in a scalar, compiled once."""

    @cache
    def made(scalar: Scalar) -> Path:
        needs("gcc", "g++")
        folder = tmp_path_factory.mktemp(scalar)
        write(folder, files(scalar))
        sources = sorted(path.name for path in folder.glob("*.c"))
        done = run(["gcc", "-std=c99", "-O2", *WARNINGS, "-c", *sources], folder)
        assert done.returncode == 0, done.stderr[:2000]
        return folder

    return made


def printed(name: str, place: Path, *arguments: str) -> FloatArray:
    """The numbers that one of the programs prints, a row a line."""
    objects = sorted(path.name for path in place.glob("*.o"))
    for step in (
        ["g++", "-std=c++17", *WARNINGS, *LENIENT, "-I.", "-I", str(PLACE / "stand-ins"),
         str(PLACE / f"{name}.cpp"), *objects, "-o", name],
        [f"./{name}", *arguments],
    ):  # fmt: skip
        done = run(step, place)
        assert done.returncode == 0, (step, done.stderr[:2000])
    return np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])


def test_a_loop_goes_on_after_a_second_failure(library: Callable[[Scalar], Path], tmp_path: Path) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    rows = [[vehicle.k, vehicle.n], *vehicle.T.tolist(), vehicle.f_min.tolist(), vehicle.f_max.tolist()]
    matrix = "\n".join(" ".join(map(repr, row)) for row in rows)
    write(tmp_path, {"matrix.txt": matrix})
    tau = np.array([30.0, -20.0, 40.0, 2.0, -1.0, 5.0])
    lines = printed("failures", library("double"), str(tmp_path / "matrix.txt"))
    once = vehicle.with_fault(0)
    for line, case in zip(lines, (vehicle, once, once.with_fault(5)), strict=True):
        expected = build("scaled", case)(tau)
        assert line[0] == expected.status
        np.testing.assert_allclose(line[1], expected.share[0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(line[2:], expected.f, rtol=0, atol=1e-9 * vehicle.f_scale)


def test_a_matrix_that_is_cut_short_is_refused(library: Callable[[Scalar], Path], tmp_path: Path) -> None:
    write(tmp_path, {"matrix.txt": "6 8 1 2 3"})
    with pytest.raises(AssertionError, match=r"failures.*matrix.txt"):
        printed("failures", library("double"), str(tmp_path / "matrix.txt"))


def px4_axes(vehicle: Vehicle) -> Vehicle:
    """The vehicle with its axes as PX4 has them, and levels as the program."""
    order = ["roll", "pitch", "yaw", "surge", "sway", "heave"]
    rows = [vehicle.dof.index(axis) for axis in order]
    levels = (("roll", "pitch", "heave"), ("surge", "sway"), ("yaw",))
    return replace(vehicle, dof=tuple(order), T=vehicle.T[rows], priority=levels)


def test_what_is_shaped_like_px4_allocates_by_priority_and_says_what_it_left(
    library: Callable[[Scalar], Path],
) -> None:
    vehicle = px4_axes(load_vehicle("bluerov2-heavy"))
    tau = np.array([4.0, 0.0, 25.0, 90.0, 0.0, 120.0])
    lines = printed("px4", library("float"))
    for line, case in zip(lines, (vehicle, vehicle.with_fault(0)), strict=True):
        expected = build("priority", case)(tau)
        assert line[0] == expected.status
        # Single precision: some dozen roundings of 6e-8 times a condition of 5.
        np.testing.assert_allclose(line[1:4], expected.share, rtol=0, atol=1e-5)
        np.testing.assert_allclose(line[4:12], expected.f, rtol=0, atol=1e-5 * vehicle.f_scale)
        rest = (tau - case.TP @ expected.f) / vehicle.wrench_scale
        np.testing.assert_allclose(line[12:] / vehicle.wrench_scale, rest, rtol=0, atol=1e-5)
    assert abs(lines[0][14]) > 1.0  # the program shows a demand that is met in part


# Single precision as above.
@pytest.mark.parametrize(("scalar", "off"), [("double", 1e-9), ("float", 1e-5)])
def test_what_is_shaped_like_a_ros_2_controller_keeps_slew_rates_and_leaves_out_what_failed(
    library: Callable[[Scalar], Path], scalar: Scalar, off: float
) -> None:
    vehicle, tau = load_vehicle("supply-vessel"), np.array([3e5, -4e5, 2e6])
    before, case = np.zeros(6), vehicle
    lines = printed("ros2", library(scalar))
    for period, line in enumerate(lines):
        low = np.clip(before - 1e5, vehicle.f_min, vehicle.f_max)
        high = np.clip(before + 1e5, vehicle.f_min, vehicle.f_max)
        expected = build("scaled", case)(tau, low, high)
        np.testing.assert_allclose(line[0], expected.share[0], rtol=0, atol=off)
        rest, f = line[1:4], line[4:]
        np.testing.assert_allclose(f, expected.f, rtol=0, atol=off * vehicle.f_scale)
        np.testing.assert_allclose(rest, tau - vehicle.T @ f, rtol=0, atol=off * np.abs(tau).max())
        before = f
        case = {1: vehicle.with_fault(1), 2: case.with_fault(4).with_fault(5)}.get(period, case)
    assert lines[2][4 + 1] == 0.0
    assert lines[0][0] < 1.0
    assert lines[3][1] == pytest.approx(tau[0])  # no thruster pushes ahead, whatever the share of the others
