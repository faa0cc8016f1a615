"""The numbers in the prose and the table of docs/autopilot.md: forces and moments added up by hand."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from alloc import build
from alloc.lint.autopilot import shares
from alloc.methods.ardusub import outputs, thrust
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


def closed_share(largest: float) -> float:
    """Share of a Heavy's wrenches by outputs up to ``largest`` for which inputs exist through the curve."""
    heavy = load_vehicle("bluerov2-heavy")
    assert heavy.autopilot is not None
    volts = 16.0

    def pushed(u: np.ndarray) -> np.ndarray:
        return heavy.thrusts(1500 + 400 * u, volts)

    mixer = replace(heavy.autopilot, thrust=np.array([pushed(np.full(8, end)) for end in (-1.0, 1.0)]))
    found, rng = [], np.random.default_rng(1)
    for asked in rng.uniform(-1, 1, (40, 6)):
        asked *= largest / np.abs(mixer.factors @ asked).max()
        tau = heavy.T @ thrust(mixer, outputs(mixer, asked[None])[0])

        def missed(inputs: np.ndarray, tau: np.ndarray = tau) -> np.ndarray:
            return (heavy.T @ pushed(outputs(mixer, inputs[None])[0]) - tau) / heavy.wrench_scale

        starts = (np.clip(more * asked, -1, 1) for more in (1.0, 1.2, 1.4))
        fits = (least_squares(missed, at, bounds=(-1, 1), x_scale=0.1, diff_step=1e-2) for at in starts)
        found.append(min(np.abs(fit.fun).max() for fit in fits) < 0.01)
    return float(np.mean(found))


def test_loops_that_close_make_up_for_the_curve_until_outputs_near_their_ends() -> None:
    said = re.search(
        r"over (\d+) % of wrenches that outputs within ±([\d.]+) make, below (\d+) % of those up to ±1",
        PAGE.read_text(encoding="utf-8"),
    )
    assert said is not None
    many, largest, few = map(float, said.groups())
    assert 100 * closed_share(largest) > many
    assert 100 * closed_share(1.0) < few
