"""``check``, ``allocate``, ``demands`` and ``run`` of a boat whose thrusters have several convex pieces."""

import csv
import io
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from click.testing import CliRunner, Result
from matplotlib.patches import Polygon

from alloc import load_vehicle
from alloc.vehicle.azimuth import excess
from bench.__main__ import cli
from bench.commands.check import _read
from bench.demands.rays import random_thrusts
from bench.demands.store import pack_vehicle, same_vehicle, unpack_vehicle
from bench.report.pictures.sketch import sketch
from bench.report.pictures.style import SETTINGS

BOAT = """\
name: boat
dof: [surge, sway, yaw]
thrusters:
  - {position: [1.8, 0, 0], azimuth: {max: 100, min: 10}, name: bow}
  - {position: [-1.8, 0, 0], azimuth: {max: 100, sector_deg: [-150, 150]}, name: stern}
  - {position: [-1, 0, 0], direction: [0, 1, 0]}
f_min: -20
f_max: 20
"""
SPLIT = """\
name: split
dof: [surge, sway]
thrusters:
  - {position: [0, 0, 0], azimuth: {max: 100, forbidden_deg: [[-30, 30], [150, 210]]}}
  - {position: [0, 0, 0], direction: [0, 1, 0]}
f_min: -60
f_max: 60
"""


def run(line: str) -> Result:
    return CliRunner().invoke(cli, line.split())


def test_check_says_pieces_their_loss_and_what_failures_leave(tmp_path: Path) -> None:
    file = tmp_path / "boat.yaml"
    file.write_text(BOAT)
    result = run(f"check {file} --no-picture")
    assert result.exit_code == 0, result.output
    assert "bow gives up to 100 N in a disc, and at least 10 N, at some angles 11.55 N;" in result.output
    assert "of it the sides of its 6 convex pieces lose 1.7 % at worst" in result.output
    assert (
        "stern gives up to 100 N in a sector from -150 to 150 degrees; of it the sides of its 2"
        in result.output
    )
    assert "warning" in result.output


def test_the_picture_has_a_polygon_for_each_piece(tmp_path: Path) -> None:
    file = tmp_path / "boat.yaml"
    file.write_text(BOAT)
    vehicle, mounting = _read(file, "")
    with mpl.rc_context(SETTINGS):
        figure = sketch(vehicle, mounting)
    drawn = [patch for patch in figure.axes[0].patches if type(patch) is Polygon]
    assert len(drawn) == 8


def test_allocate_keeps_the_last_piece_from_row_to_row(tmp_path: Path) -> None:
    file, asked = tmp_path / "split.yaml", tmp_path / "asked.csv"
    file.write_text(SPLIT)
    asked.write_text("surge,sway\n40,3\n40,-0.3\n40,0.2\n40,-0.1\n40,-30\n")
    result = run(f"allocate --vehicle {file} --method nullspace {asked}")
    assert result.exit_code == 0, result.output
    rows = list(csv.DictReader(io.StringIO(result.stdout)))
    assert [np.sign(float(row["f1"])) for row in rows] == [1, 1, 1, 1, -1]
    assert [float(row["angle0"]) > 0 for row in rows] == [True] * 4 + [False]


def test_demands_are_labelled_by_the_union_and_run_refuses_it_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("boat.yaml").write_text(BOAT)
    Path("asked.csv").write_text("surge,sway,yaw\n50,0,0\n900,0,0\n")
    result = run("demands asked.csv --vehicle boat.yaml")
    assert result.exit_code == 0, result.output
    assert "infeasible                 50.00 % of demands" in result.output
    for line in ("run --quick --vehicle boat.yaml", "run --vehicle boat.yaml --demands asked.csv"):
        refused = run(f"{line} --out out")
        assert str(refused.exception).endswith(
            "6 convex pieces, and run takes sets of one piece alone; see docs/azimuth.md"
        )
        assert not Path("out/record.jsonl").exists()


def test_a_vehicle_of_pieces_is_stored_and_read_whole(tmp_path: Path) -> None:
    file = tmp_path / "boat.yaml"
    file.write_text(BOAT)
    vehicle = load_vehicle(file)
    again = unpack_vehicle(pack_vehicle(vehicle))
    assert same_vehicle(vehicle, again)
    assert [len(azimuth.parts) for azimuth in again.azimuths] == [6, 2]
    assert [azimuth.sector for azimuth in again.azimuths] == [None, (-150.0, 150.0)]
    for one, two in zip(vehicle.azimuths, again.azimuths, strict=True):
        assert [a.tolist() for a in one.pieces] == [b.tolist() for b in two.pieces]


def test_thrusts_drawn_at_random_lie_in_pieces_and_in_each(tmp_path: Path) -> None:
    file = tmp_path / "boat.yaml"
    file.write_text(BOAT)
    vehicle = load_vehicle(file)
    F = random_thrusts(vehicle, np.random.default_rng(2), 500)
    assert excess(vehicle.turning, F, vehicle.f_min, vehicle.f_max, 0.0).max() <= 1e-9
    for azimuth in vehicle.azimuths:
        inside = [excess([part], F, -np.full(5, 1e9), np.full(5, 1e9), 0.0) for part in azimuth.parts]
        assert all((each[:, azimuth.first] <= 1e-9).any() for each in inside)
