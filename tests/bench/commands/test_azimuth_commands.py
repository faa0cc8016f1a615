"""``check`` and ``allocate`` of a ferry whose thrusters turn."""

import csv
import io
import json
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.patches import Polygon
from matplotlib.text import Annotation

from alloc import build, load_vehicle
from alloc.errors import PluginError
from alloc.vehicle.file import find_file
from bench.__main__ import cli
from bench.commands.check import _read
from bench.report.pictures.sketch import SHORT_ARROW, sketch
from bench.report.pictures.style import SETTINGS
from tests.azimuths import FERRY

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
MIXED = """\
name: boat
dof: [surge, sway, yaw]
thrusters:
  - {position: [0.5, 0, 0], direction: [0, 1, 0], name: tunnel}
  - {position: [1.8, 0.4, 0], azimuth: {max: 200}, name: bow}
  - {position: [-1.8, 0, 0], azimuth: {max: 500, sector_deg: [-20, 90], sides: 32}, name: stern}
  - {position: [-0.5, 0, 0], direction: [0, 1, 0], name: weak}
f_min: [-300, -20]
f_max: [250, 10]
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


def test_angles_of_a_file_go_the_shortest_way_round_from_row_to_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Red before: 170 deg was followed by -170, which is 340 deg away, and no force by 0 deg."""
    monkeypatch.chdir(tmp_path)
    degrees = [170, 190, 350, 380]
    rows = [[300 * np.cos(np.radians(a)), 300 * np.sin(np.radians(a)), 0.0] for a in degrees]
    asked = [rows[0], [0.0] * 3, [1e6, 0.0, 0.0], *rows[1:]]
    (tmp_path / "asked.csv").write_text("surge,sway,yaw\n" + "\n".join(",".join(map(str, r)) for r in asked))
    text = run("allocate --vehicle double-ended-ferry --method nullspace asked.csv")
    for i in (0, 1):
        said = [float(row[f"angle{i}"]) for row in csv.DictReader(io.StringIO(text))]
        assert said == pytest.approx([170, 170, np.nan, 190, 350, 380], nan_ok=True)


def test_angles_of_a_file_stay_within_the_sector(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Red before: 0, -90, -270, -450."""
    monkeypatch.chdir(tmp_path)
    boat = FERRY.replace("max: 100}, name: stern", "max: 100, sector_deg: [-90, 90]}, name: stern")
    (tmp_path / "boat.yaml").write_text(boat)
    (tmp_path / "asked.csv").write_text("surge,sway,yaw\n0,0,0\n0,-90,0\n0,90,0\n0,-90,0\n")
    text = run("allocate --vehicle boat.yaml --method nullspace asked.csv")
    said = [float(row["angle1"]) for row in csv.DictReader(io.StringIO(text))]
    assert said == pytest.approx([0, -90, 90, -90])


def test_a_ferry_s_copy_goes_through_the_first_steps_of_the_readme(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run("init mine --like double-ended-ferry")
    mine, ferry = load_vehicle("mine.yaml"), load_vehicle("double-ended-ferry")
    assert mine.names == ferry.names
    assert (mine.T == ferry.T).all()
    assert [one.corners.tolist() for one in mine.azimuths] == [one.corners.tolist() for one in ferry.azimuths]
    assert "mine.yaml: 0 errors" in run("check mine.yaml")
    said = run("demands demands.csv --vehicle mine.yaml")
    assert "infeasible                  20.00 %" in said  # the last of five, 1.5 times what there is
    answers = [
        [row["status"] for row in csv.DictReader(io.StringIO(run(f"allocate --vehicle mine.yaml {line}")))]
        for line in ("--method nullspace demands.csv", "--method my_allocator.py demands.csv")
    ]
    assert answers == [["SOLVED"] * 4 + ["INFEASIBLE"], ["SOLVED"] * 5]


def test_check_says_the_sets_what_polygons_lose_and_what_failures_cost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = run("check double-ended-ferry")
    assert "3 DOF, 2 thrusters, rank 3, d = 1" in text
    for name in ("bow", "stern"):
        assert f"{name} gives up to 500 N in a disc; of it the 16 sides of the polygon lose 1.9 %" in text
    assert "without bow or stern: no" in text
    assert "double-ended-ferry.svg: drawn" in text
    report = json.loads(run("check double-ended-ferry --json"))
    assert report["usable"]
    assert report["facts"]["n"] == 2


def test_check_says_what_is_wrong_with_an_azimuth(tmp_path: Path) -> None:
    file = tmp_path / "boat.yaml"
    file.write_text(find_file("double-ended-ferry").read_text().replace("sides: 16", "sides: 2", 1))
    said = CliRunner().invoke(cli, ["check", str(file)]).stdout
    assert "error    line 8, thrusters[0].azimuth.sides: is 2; give 3 to 64 sides" in said


@pytest.mark.parametrize(("frame", "starboard"), [("frd", 1.0), ("flu", -1.0)])
def test_the_drawing_shows_polygons_from_above_on_the_scale_of_arrows(
    frame: str, starboard: float, tmp_path: Path
) -> None:
    """Red before: ``check`` drew no vehicle whose thrusters turn."""
    (tmp_path / "boat.yaml").write_text(f"{MIXED}frame: {frame}\n")
    vehicle, mounting = _read(tmp_path / "boat.yaml", "")
    with mpl.rc_context(SETTINGS):
        above, *others = sketch(vehicle, mounting).axes
    bow, stern = (np.array(patch.get_xy())[:-1] for patch in above.patches if isinstance(patch, Polygon))
    assert not any(isinstance(patch, Polygon) for axes in others for patch in axes.patches)
    tunnel, weak = (text for text in above.texts if isinstance(text, Annotation) and text.arrow_patch)
    metres = float(np.linalg.norm(np.subtract(tunnel.xy, tunnel.xyann)))
    newton = metres / 300.0  # its larger limit
    places = [[starboard * 0.4, 1.8], [0.0, -1.8]]
    for drawn, azimuth, place in zip((bow, stern), vehicle.azimuths, places, strict=True):
        ahead = azimuth.corners[:, ::-1] * [starboard, 1.0]
        np.testing.assert_allclose(drawn, place + newton * ahead, atol=1e-12)
    # In closed form: radii of disc and sector, and where the sector lies, from ahead towards y [deg].
    np.testing.assert_allclose(np.linalg.norm(bow - places[0], axis=1), 200.0 * newton)
    assert np.linalg.norm(stern - places[1], axis=1).max() == pytest.approx(500.0 * newton)
    bearings = np.degrees(np.arctan2(*(stern[1:] - places[1]).T)) * starboard
    assert (bearings.min(), bearings.max()) == pytest.approx((-20.0, 90.0))
    longest = 500.0 * newton
    assert np.linalg.norm(np.subtract(weak.xy, weak.xyann)) == pytest.approx(SHORT_ARROW * longest)
    assert {"tunnel", "weak", "bow", "stern"} <= {text.get_text() for text in above.texts}


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


def test_the_list_has_vehicles_whose_thrusters_turn_and_counts_thrusters() -> None:
    lines = run("list").splitlines()
    (at,) = (i for i, line in enumerate(lines) if line.startswith("offshore-supply-vessel"))
    assert lines[at].split()[1:4] == ["3", "4", "3"]
    assert lines[at + 1].strip().startswith("2 of them turn; cybergalactic/MSS")
