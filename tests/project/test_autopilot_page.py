"""The numbers in the prose and the table of docs/autopilot.md: forces and moments added up by hand."""

import re
from pathlib import Path

import numpy as np
import pytest

from alloc import build
from alloc.lint.autopilot import shares
from alloc.vehicle.file import load_vehicle
from alloc.vehicle.geometry import DOF
from bench.judging.mixer import simulate_moves
from tests.pages import saved
from tests.places import DOCS

PAGE = DOCS / "autopilot.md"
CELL = re.compile(r"(\w+) (-?[\d.]+)")


def wrench(cell: str, dof: tuple[str, ...]) -> np.ndarray:
    """The wrench that a cell of the table spells: axes and numbers, 0 for those it leaves out."""
    said = {axis: float(number) for axis, number in CELL.findall(cell)}
    return np.array([said.get(axis, 0.0) for axis in dof])


def test_the_table_shows_what_each_method_makes_of_each_move(tmp_path: Path) -> None:
    saved(PAGE, tmp_path)
    vehicle = load_vehicle(tmp_path / "payload.yaml")
    moves = np.loadtxt(tmp_path / "moves.csv", delimiter=",", skiprows=1)
    rows = [
        line.split("|")[1:-1] for line in PAGE.read_text(encoding="utf-8").splitlines() if "| surge" in line
    ]
    assert len(rows) == len(moves)
    for (asked, mixed, _, exact), tau in zip(rows, moves, strict=True):
        np.testing.assert_array_equal(wrench(asked, vehicle.dof), tau)
        for method, cell in (("ardusub", mixed), ("scaled", exact)):
            made = vehicle.T @ build(method, vehicle)(tau).f
            np.testing.assert_allclose(wrench(cell, vehicle.dof), made, rtol=1e-3, atol=1e-6)


def test_the_turn_in_the_prose_is_that_of_the_simulated_move(tmp_path: Path) -> None:
    saved(PAGE, tmp_path)
    vehicle = load_vehicle(tmp_path / "payload.yaml")
    move = next(simulate_moves(vehicle, build("ardusub", vehicle), build("scaled", vehicle)))
    found = re.search(r"turns by ([\d.]+)°, with `scaled` by (\d+)°", PAGE.read_text(encoding="utf-8"))
    assert found is not None
    assert (move.axis, *move.turned_deg) == ("surge", *map(float, found.groups()))


def test_the_thrust_at_half_an_output_is_that_of_the_pulse_half_way_to_the_end() -> None:
    (half, whole) = re.findall(r"makes ([\d.]+) of ([\d.]+) N at 16 V", PAGE.read_text(encoding="utf-8"))[0]
    heavy = load_vehicle("bluerov2-heavy")
    made = heavy.thrusts([[1700] * 8, [1900] * 8], 16.0)[:, 0]
    assert made == pytest.approx([float(half), float(whole)], abs=0.05)


def test_the_two_couplings_in_the_prose_are_those_of_the_table(tmp_path: Path) -> None:
    saved(PAGE, tmp_path)
    vehicle = load_vehicle(tmp_path / "payload.yaml")
    assert vehicle.autopilot is not None
    table = shares(vehicle, vehicle.autopilot, vehicle.autopilot.factors)
    forward, throttle = map(float, re.findall(r"makes ([\d.]+) %", PAGE.read_text(encoding="utf-8")))
    assert table[DOF.index("yaw"), DOF.index("surge")] == pytest.approx(forward, abs=0.05)
    assert table[DOF.index("roll"), DOF.index("heave")] == pytest.approx(throttle, abs=0.05)
