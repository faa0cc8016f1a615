"""`thrustbench allocate`: demands in, thrusts out, as a script would use it."""

import csv
import io
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from alloc import AllocError, build, load_vehicle
from alloc.errors import DemandError
from alloc.vehicle.file import find_file
from bench.__main__ import cli
from tests import plugin_files
from tests.plugin_files import write_plugin

PAPER = (300.0, -50.0, 10.0)
PAPER_F = np.array([67.5, 104.0, -119.1, -52.4])
"""Demand and thrusts of section 4.2 of the paper, in its four digits."""


NOTHING = "return Allocation(f * np.nan, Status.INFEASIBLE)"


def allocate(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["allocate", *map(str, arguments)], standalone_mode=False)


def thrusts(text: str) -> tuple[list[str], np.ndarray]:
    rows = list(csv.reader(io.StringIO(text)))
    assert rows[0] == ["status", "f0", "f1", "f2", "f3"]
    return [row[0] for row in rows[1:]], np.array([[float(x) for x in row[1:]] for row in rows[1:]])


@pytest.fixture
def demands(tmp_path: Path) -> Path:
    path = tmp_path / "demands.csv"
    path.write_text("yaw,surge,sway\n10,300,-50\n0,1e-3,0\n0,1e6,0\n")  # any order of columns
    return path


@pytest.mark.parametrize("method", ["pinv", "svd", "walsh", "nullspace"])
def test_the_papers_example_comes_out_in_its_digits_and_each_row_in_order(demands: Path, method: str) -> None:
    result = allocate("--vehicle", "ukwial", "--method", method, demands)
    statuses, F = thrusts(result.stdout)
    assert statuses[:2] == ["SOLVED", "SOLVED"]
    np.testing.assert_allclose(F[0], PAPER_F, atol=0.05)
    vehicle = load_vehicle("ukwial")
    np.testing.assert_allclose(F[:2] @ vehicle.TP.T, [PAPER, (1e-3, 0, 0)], atol=1e-7)  # ten digits


def test_a_qp_solver_at_its_defaults_comes_as_near_as_it_promises(demands: Path) -> None:
    statuses, F = thrusts(allocate("--vehicle", "ukwial", "--method", "qp/osqp", demands).stdout)
    vehicle = load_vehicle("ukwial")
    assert statuses[0] in ("SOLVED", "PARTIAL")  # PARTIAL where the wrench is met, but not to 1e-6
    assert np.abs(F[0] - PAPER_F).max() <= build("qp/osqp", vehicle).tolerance * vehicle.f_scale + 0.05


def test_a_demand_that_no_thrust_meets_is_a_row_that_says_so(demands: Path) -> None:
    statuses, F = thrusts(allocate("--vehicle", "ukwial", "--method", "nullspace", demands).stdout)
    assert statuses[2] == "INFEASIBLE"
    assert np.isnan(F[2]).all()


def test_what_a_method_prints_does_not_come_between_the_rows(demands: Path, tmp_path: Path) -> None:
    plugin = write_plugin(tmp_path, "floods")
    options = ("--vehicle", "ukwial", "--method", "floods", "--plugin", plugin, str(demands))
    command = [sys.executable, "-m", "bench", "allocate", *options]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    statuses, _ = thrusts(result.stdout)
    assert statuses == ["SOLVED"] * 3
    assert result.stderr.count("x" * 10_000) == 3


def test_a_plug_in_may_print_and_change_the_folder_as_it_is_imported(
    demands: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Standard output was the CSV's header, and the CSV lay in the other folder."""
    monkeypatch.setitem(plugin_files.BODIES, "moves", "pass")
    plugin = write_plugin(tmp_path, "moves")
    Path(plugin).write_text(f"import os\nprint('gains')\nos.chdir('..')\n{Path(plugin).read_text()}")
    monkeypatch.chdir(tmp_path)
    asked = ("--vehicle", "ukwial", "--method", "moves", "--plugin", plugin, demands)
    assert allocate(*asked).stdout.startswith("status,f0")
    allocate(*asked, "-o", "thrusts.csv")
    assert (tmp_path / "thrusts.csv").exists()


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("return None", "TypeError"),
        ("return Allocation(f, 77)", "77 is not a valid Status"),
        ("return Allocation(f[:2], Status.SOLVED)", r"thrusts of shape \(2,\), not \(4,\)"),
        ("sys.exit(0)", "line \\d+: SystemExit: 0"),
        ("os._exit(0)", r"ended its process \(exit code 0\) before it had answered"),
        ("os.kill(os.getpid(), 9)", r"ended its process \(SIGKILL\) before it had answered"),
        (plugin_files.BODIES["nan"], "demand 2, counted from 0: NaN or infinity although it says SOLVED"),
        (plugin_files.BODIES["off"], "demand 0, .*SOLVED, but the wrench is not met"),
        (plugin_files.BODIES["changes-its-vehicle"], "demand 0, .*SOLVED, but the wrench is not met"),
        ("tau *= 0; f = f * 0", "demand 0, .*SOLVED, but the wrench is not met"),
        ("self.f[:] = self.G @ [10, 0, 0]; f = self.f; tau[:] = 10, 0, 0", "demand 0, "),
        ("self.limited = True", "demand 2, .*a limit is violated"),
        (NOTHING, "demand 0, .*says INFEASIBLE, but a thrust inside the limits gives this wrench"),
    ],
)
def test_a_plug_in_whose_answer_is_none_or_wrong_ends_in_one_line(
    demands: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, body: str, says: str
) -> None:
    monkeypatch.setitem(plugin_files.BODIES, "useless", body)
    plugin = write_plugin(tmp_path, "useless")
    error = allocate("--vehicle", "ukwial", "--method", "useless", "--plugin", plugin, demands).exception
    assert isinstance(error, AllocError)
    assert re.fullmatch(f".*useless.py: .*{says}.*; mend it", str(error))  # one line


@pytest.mark.parametrize(
    ("function", "columns", "says"),
    [
        ("lambda tau: tau", "", r"the function gave an array of shape \(3,\); return 4 thrusts"),
        ("lambda tau: tau[[0, 0, 1, 2]]", ",f0_max", "the function takes no limits of each call"),
        ("7", "", r"build\(vehicle\) gave int"),
    ],
)
def test_what_a_plain_function_can_t_do_names_its_file(
    tmp_path: Path, function: str, columns: str, says: str
) -> None:
    plugin, log = tmp_path / "short.py", tmp_path / "log.csv"
    plugin.write_text(f"def build(vehicle):\n    return {function}\n")
    log.write_text(f"surge,sway,yaw{columns}\n1,2,3{',4' if columns else ''}\n")
    error = allocate("--vehicle", "ukwial", "--method", "short", "--plugin", plugin, log).exception
    assert re.match(f"{re.escape(str(plugin))}: {says}", str(error))


def test_of_several_plug_ins_that_of_the_method_is_asked(demands: Path, tmp_path: Path) -> None:
    """The last one was, and its method was advised."""
    both = [word for name in ("sleeps", "off") for word in ("--plugin", write_plugin(tmp_path, name))]
    assert allocate("--vehicle", "ukwial", "--method", "sleeps", *both, demands).stdout.count("SOLVED") == 3
    result = allocate("--vehicle", "ukwial", "--method", "off", *both, demands)
    assert "off.py: demand 0, " in str(result.exception)


def test_a_plug_in_may_refuse_what_no_thrust_meets(
    demands: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(plugin_files.BODIES, "refuses", f"if large: {NOTHING}")
    plugin = write_plugin(tmp_path, "refuses")
    result = allocate("--vehicle", "ukwial", "--method", "refuses", "--plugin", plugin, demands)
    assert thrusts(result.stdout)[0] == ["SOLVED", "SOLVED", "INFEASIBLE"]


def test_numbers_read_back_as_the_same_doubles(demands: Path, tmp_path: Path) -> None:
    out = tmp_path / "thrusts.csv"
    assert allocate("--vehicle", "ukwial", "--method", "pinv", demands, "-o", out).stdout == ""
    _, F = thrusts(out.read_text())
    vehicle = load_vehicle("ukwial")
    expected = np.array([PAPER, (1e-3, 0, 0), (1e6, 0, 0)]) @ np.linalg.pinv(vehicle.T).T
    np.testing.assert_allclose(F, expected, rtol=1e-9, atol=1e-10)  # ten digits are written


def test_a_method_with_levels_says_what_it_delivered_of_each(tmp_path: Path) -> None:
    """supply-vessel serves yaw first; what is delivered is the share of what is asked, axis by axis."""
    tau = np.array([1e6, 2e5, 4e7])
    path = tmp_path / "demands.csv"
    path.write_text("surge,sway,yaw\n" + ",".join(map(str, tau)) + "\n0,0,0\n")
    rows = list(
        csv.DictReader(
            io.StringIO(allocate("--vehicle", "supply-vessel", "--method", "priority", path).stdout)
        )
    )
    assert list(rows[0]) == ["status", *(f"f{i}" for i in range(6)), "share0", "share1"]
    share = [float(rows[0]["share0"]), float(rows[0]["share1"])]
    assert max(share) < 1
    f = np.array([float(rows[0][f"f{i}"]) for i in range(6)])
    np.testing.assert_allclose(
        load_vehicle("supply-vessel").TP @ f / tau, [share[1], share[1], share[0]], rtol=1e-8
    )
    assert (rows[1]["status"], rows[1]["share0"], rows[1]["share1"]) == ("SOLVED", "1", "1")


def test_a_failed_thruster_stays_at_rest(demands: Path) -> None:
    result = allocate("--vehicle", "ukwial", "--method", "svd", "--fault", "1", demands)
    _, F = thrusts(result.stdout)
    assert (F[:, 1] == 0).all()


def test_thrusters_are_named_in_fault_and_header_as_the_vehicle_names_them(tmp_path: Path) -> None:
    shipped = Path(str(find_file("ukwial"))).read_text(encoding="utf-8")
    mine = tmp_path / "mine.yaml"
    mine.write_text(f"{shipped}\nnames: [bow port, bow starboard, stern port, '']\n", encoding="utf-8")
    (tmp_path / "ask.csv").write_text("surge,sway,yaw\n10,0,0\n")
    options = ("--vehicle", str(mine), "--method", "svd", tmp_path / "ask.csv")
    by_name = allocate(*options, "--fault", "bow starboard", "--names").stdout
    assert by_name.splitlines()[0] == "status,bow port,bow starboard,stern port,thruster 3"
    assert by_name.splitlines()[1:] == allocate(*options, "--fault", "1").stdout.splitlines()[1:]


def test_how_a_log_was_understood_is_said_beside_the_thrusts(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time [ms];Fx;Fy;Mz\n0;10,5;0;0\n")
    result = allocate("--vehicle", "ukwial", "--method", "pinv", tmp_path / "log.csv")
    assert result.stderr.startswith("log.csv: surge from 'Fx' [N]; ")
    _, F = thrusts(result.stdout)
    np.testing.assert_allclose(load_vehicle("ukwial").T @ F[0], [10.5, 0, 0], atol=1e-7)


def test_with_esc_each_row_has_the_commands_and_the_wrench_that_they_make(tmp_path: Path) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    demands = tmp_path / "demands.csv"
    axes = ",".join(vehicle.dof)
    demands.write_text(f"{axes},volts\n20,-5,8,0,0,1,15\n2000,0,0,0,0,0,14\n")
    result = allocate(demands, "--vehicle", vehicle.name, "--method", "nullspace", "--esc")
    solved, infeasible = csv.DictReader(result.stdout.splitlines())
    f = np.array([float(solved[f"f{i}"]) for i in range(8)])
    sent = vehicle.commands(f, 15)
    assert [int(solved[f"u{i}"]) for i in range(8)] == sent.u.tolist()
    made = [float(solved[f"made_{axis}"]) for axis in vehicle.dof]
    assert made == pytest.approx(vehicle.T @ vehicle.thrusts(sent.u, 15), abs=1e-8)  # ten digits are written
    assert made == pytest.approx([20, -5, 8, 0, 0, 1], abs=0.5)  # eight steps of 1 µs, some 0.1 N each
    assert {infeasible[f"u{i}"] for i in range(8)} == {"1500"}


WIRED = """\
name: wired
dof: [surge, sway, yaw]
T: [[1, 1, 1, 1], [1, -1, -1, 1], [0.3, 0.3, -0.3, -0.3]]
f_min: -40
f_max: 60
priority: [[yaw], [sway], [surge]]
esc:
  neutral: 1500
  range: [1100, 1900]
  volts: 16
  curve:
    12: [[1100, -20], [1470, 0], [1530, 0], [1900, 25]]
    16: [[1100, -40], [1470, 0], [1530, 0], [1900, 51]]
"""
"""Limits beyond the curve at 16 V, and far beyond that at 12 V."""


@pytest.mark.parametrize("method", ["scaled", "priority"])
@pytest.mark.parametrize(
    ("volts", "table"),
    [("", ""), (",12", ""), (",14.5", ""), (",12", "volts: {12: [-40, 60], 16: [-40, 60]}\n")],
)
def test_with_esc_shares_are_those_of_the_wrench_that_the_commands_make(
    method: str, volts: str, table: str, tmp_path: Path
) -> None:
    """Limits of 60 N gave shares of 1 at 16 V, where ESCs make 51 N; so did a table of limits at 12 V."""
    (tmp_path / "wired.yaml").write_text(WIRED + table)
    demands, tau = tmp_path / "demands.csv", np.array([210.0, 45.0, 18.0])
    demands.write_text(f"surge,sway,yaw{',volts' * bool(volts)}\n210,45,18{volts}\n10,2,1{volts}\n")
    result = allocate(demands, "--vehicle", tmp_path / "wired.yaml", "--method", method, "--esc")
    cut, met = csv.DictReader(result.stdout.splitlines())
    share = np.array([float(cut.get(f"share{level}") or cut["share0"]) for level in (2, 1, 0)])
    made = np.array([float(cut[f"made_{axis}"]) for axis in ("surge", "sway", "yaw")])
    step = 51 / 370 / 2
    assert share.min() < 1
    assert (np.abs(made - share * tau) <= step * np.array([4, 4, 1.2])).all()
    assert (cut["status"], met["status"], met["share0"]) == ("PARTIAL", "SOLVED", "1")


def test_with_esc_a_plug_in_s_function_of_the_demand_alone_is_held_to_what_the_escs_make(
    tmp_path: Path,
) -> None:
    (tmp_path / "wired.yaml").write_text(WIRED)
    plugin, demands = tmp_path / "spread.py", tmp_path / "demands.csv"
    plugin.write_text(
        "import numpy as np\n\nLIMITED = True\n\n\ndef build(vehicle):\n"
        "    return lambda tau: np.clip(np.linalg.pinv(vehicle.T) @ tau, vehicle.f_min, vehicle.f_max)\n"
    )
    demands.write_text("surge,sway,yaw\n220,0,0\n")
    asked = ("--vehicle", tmp_path / "wired.yaml", "--method", "spread", "--plugin", plugin, "--esc")
    (row,) = csv.DictReader(allocate(demands, *asked).stdout.splitlines())
    assert (row["status"], row["f0"], row["made_surge"]) == ("PARTIAL", "51", "204")


FUSED = """\
name: fused
dof: [surge, yaw]
T: [[1, 1], [0.2, -0.2]]
esc:
  {neutral: 0, range: [-9, 9], step: 0.1, volts: 12, curve: {12: [[-9, -40], [0, 0], [9, 40]]},
   current: {ahead: 0.1, astern: 0.1, power: 2}}
cap: {watts: 276, reserve: 36}
"""


@pytest.mark.parametrize(("cap", "amps"), [("20", 20.0), ("file", 20.0), ("5", 5.0), ("900", 320.0)])
def test_with_a_cap_the_thrusters_draw_no_more_and_the_share_says_what_is_left(
    cap: str, amps: float, tmp_path: Path
) -> None:
    (tmp_path / "fused.yaml").write_text(FUSED)
    demands = tmp_path / "demands.csv"
    demands.write_text("surge,yaw\n80,0\n1,0\n")
    result = allocate(demands, "--vehicle", tmp_path / "fused.yaml", "--method", "scaled", "--cap", cap)
    cut, met = csv.DictReader(result.stdout.splitlines())
    f = np.array([float(cut["f0"]), float(cut["f1"])])
    assert (0.1 * f**2).sum() == pytest.approx(amps)
    assert float(cut["share0"]) == pytest.approx(f.sum() / 80)
    assert (met["status"], met["share0"]) == ("SOLVED", "1")


def test_with_a_cap_the_commands_draw_no_more_either(tmp_path: Path) -> None:
    (tmp_path / "fused.yaml").write_text(FUSED)
    vehicle, demands = load_vehicle(tmp_path / "fused.yaml"), tmp_path / "demands.csv"
    demands.write_text("surge,yaw\n" + "".join(f"80,{yaw / 10}\n" for yaw in range(20)))
    result = allocate(
        demands, "--vehicle", tmp_path / "fused.yaml", "--method", "scaled", "--cap", "20", "--esc"
    )
    sent = [[float(row["u0"]), float(row["u1"])] for row in csv.DictReader(result.stdout.splitlines())]
    assert vehicle.draw().amps(vehicle.thrusts(sent)).sum(axis=1).max() <= 20.0 + 1e-9


@pytest.mark.parametrize(
    ("method", "cap", "said"),
    [
        ("scaled", "much", "--cap: got 'much', expected a number of amperes, or file"),
        ("scaled", "nan", "cap: got nan, expected a finite number of amperes"),
        ("scaled", "file", "ukwial: has no cap for --cap file; add 'cap' to its file"),
        ("scaled", "20", "ukwial: has no currents; add 'current' to 'esc'"),
        ("nullspace", "20", "cap: methods for 'hard' take none; use scaled"),
        ("scaled@native", "20", "cap: compiled methods take none; use scaled"),
    ],
)
def test_a_cap_that_can_t_be_kept_is_refused(demands: Path, method: str, cap: str, said: str) -> None:
    result = allocate(demands, "--vehicle", "ukwial", "--method", method, "--cap", cap)
    assert isinstance(result.exception, AllocError)
    assert said in str(result.exception)


def allocate_as(directory: Path, *options: str, vehicle: str = "ukwial", first: str) -> Result:
    """Thrusts of one demand on a shipped vehicle whose first thruster has this name."""
    text = find_file(vehicle).read_text(encoding="utf-8")
    n, dof = (8, "surge,sway,heave,roll,pitch,yaw") if vehicle != "ukwial" else (4, "surge,sway,yaw")
    others = "".join(f", t{i}" for i in range(1, n))
    mine, log = directory / "mine.yaml", directory / "log.csv"
    mine.write_text(f"{text}\nnames: ['{first}'{others}]\n", encoding="utf-8")
    for curve in find_file(vehicle).parent.glob("*.csv"):
        (directory / curve.name).write_bytes(curve.read_bytes())
    log.write_text(f"{dof}\n{','.join('1' * (dof.count(',') + 1))}\n")
    words = ["allocate", str(log), "--vehicle", str(mine), "--names", *options]
    return CliRunner().invoke(cli, words, standalone_mode=False)


@pytest.mark.parametrize("name", ["=1+1", "+cmd", "-2+3"])
def test_a_spreadsheet_shows_a_name_that_looks_like_a_formula(name: str, tmp_path: Path) -> None:
    printed = allocate_as(tmp_path, "--method", "pinv", first=name).stdout
    assert printed.splitlines()[0] == f"status,'{name},t1,t2,t3"


@pytest.mark.parametrize(
    ("name", "method", "vehicle", "more"),
    [
        ("status", "pinv", "ukwial", ()),
        ("share0", "scaled", "ukwial", ()),
        ("u0", "clip", "bluerov2-heavy", ("--esc",)),
        ("made_surge", "clip", "bluerov2-heavy", ("--esc",)),
    ],
)
def test_no_two_columns_have_one_name(
    name: str, method: str, vehicle: str, more: tuple[str, ...], tmp_path: Path
) -> None:
    result = allocate_as(tmp_path, "--method", method, *more, vehicle=vehicle, first=name)
    assert isinstance(result.exception, DemandError)
    assert str(result.exception).startswith(f"--names: two columns would be '{name}'; ")
    assert result.stdout == ""
