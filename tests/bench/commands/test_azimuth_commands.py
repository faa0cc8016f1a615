"""``check`` and ``allocate`` of a ferry whose thrusters turn."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import build, load_vehicle
from alloc.errors import PluginError
from alloc.vehicle.file import find_file
from bench.__main__ import cli

DEMANDS = "surge,sway,yaw\n300,-50,400\n-600,0,0\n5000,0,0\n"
PLUGIN = """\
import numpy as np
from alloc import Allocation, Status

FORMULATION, AZIMUTHS = "hard", True

def build(vehicle):
    def allocate(tau, f_min=None, f_max=None):
        return np.array([350.0, {sway}, -350.0, -{sway}])
    return allocate
"""


def run(line: str) -> str:
    result = CliRunner().invoke(cli, line.split())
    assert result.exit_code == 0, result.output
    return result.stdout


def test_allocate_writes_components_then_forces_and_angles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "asked.csv").write_text(DEMANDS)
    ferry = load_vehicle("double-ended-ferry")
    for method in ("nullspace", "scaled", "qp/daqp"):
        text = run(f"allocate --vehicle double-ended-ferry --method {method} asked.csv")
        rows = list(csv.DictReader(io.StringIO(text)))
        assert [*rows[0]][:5] == ["status", "f0", "f1", "f2", "f3"]
        assert [*rows[0]][-4:] == ["force0", "angle0", "force1", "angle1"]
        assert rows[2]["status"] == ("PARTIAL" if method == "scaled" else "INFEASIBLE")
        for row, tau in zip(rows[:2], ([300, -50, 400], [-600, 0, 0]), strict=True):
            f = build(method, ferry)(tau).f
            x = [float(row[f"force{i}"]) * np.cos(np.radians(float(row[f"angle{i}"]))) for i in (0, 1)]
            y = [float(row[f"force{i}"]) * np.sin(np.radians(float(row[f"angle{i}"]))) for i in (0, 1)]
            assert np.column_stack([x, y]).ravel() == pytest.approx(f, abs=1e-6)
        assert rows[1]["angle0"] == "180"


def test_with_a_failed_thruster_allocate_goes_on_with_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "asked.csv").write_text("surge,sway,yaw\n300,0,0\n")
    text = run("allocate --vehicle double-ended-ferry --method nullspace --fault bow asked.csv")
    (row,) = csv.DictReader(io.StringIO(text))
    assert (row["status"], row["force0"], row["force1"], row["angle1"]) == ("SOLVED", "0", "300", "0")


def test_check_says_the_sets_what_polygons_lose_and_what_failures_cost() -> None:
    text = run("check double-ended-ferry")
    assert "3 DOF, 2 thrusters, rank 3, d = 1" in text
    for name in ("bow", "stern"):
        assert f"{name} gives up to 500 N in a disc; of it the 16 sides of the polygon lose 1.9 %" in text
    assert "without bow or stern: no" in text
    report = json.loads(run("check double-ended-ferry --json"))
    assert report["usable"]
    assert report["facts"]["n"] == 2


def test_check_says_what_is_wrong_with_an_azimuth(tmp_path: Path) -> None:
    file = tmp_path / "boat.yaml"
    file.write_text(find_file("double-ended-ferry").read_text().replace("sides: 16", "sides: 2", 1))
    said = CliRunner().invoke(cli, ["check", str(file)]).stdout
    assert "error    line 8, thrusters[0].azimuth.sides: is 2; give 3 to 64 sides" in said


@pytest.mark.parametrize(("sway", "wrong"), [(0.0, False), (355.0, False), (360.0, True)])
def test_a_plug_in_is_held_to_the_polygons(
    sway: float, wrong: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(PLUGIN.format(sway=sway))
    (tmp_path / "asked.csv").write_text(f"surge,sway,yaw\n0,0,{3.6 * sway}\n")
    line = "allocate --vehicle double-ended-ferry --method mine.py asked.csv"
    result = CliRunner().invoke(cli, line.split())
    assert isinstance(result.exception, PluginError) == wrong
    assert ("a limit is violated, by 3.4 N" in str(result.exception)) == wrong
