"""``thrustbench check`` on published, shipped and spoiled vehicle files."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from alloc import list_vehicles
from alloc.lint.check import check_vehicle
from alloc.lint.report import Level, Report, as_table
from tests.places import ROOT

PUBLISHED = Path(__file__).parent / "data" / "published"
DEFECTS = {
    "vortex-beluga": [
        "yaw of thruster 0 is 0.3, but its pose makes -0.3239",
        "(8 of 8 thrusters differ)",
    ],
    "vortex-manta-enu": [
        "the heave row has the opposite sign",
        "pitch of thruster 1 is 0.12, but its pose makes -0.1207",
    ],
    "desistek-saga": [
        "the pitch row has the opposite sign",
        "T has rank 3 but 6",
        "no thruster pushes roll; none - 0.13 surge - 0.99 heave + pitch; none sway",
    ],
    "bluerov2-vectored6-centralenantes": [
        "T has rank 5 but 6",
        "no thruster pushes surge + 0.034 heave + pitch",
    ],
    "girona500": ["T has rank 5 but 6", "no thruster pushes - sway + roll"],
}
"""Known defects of the published vehicles; the other ones of the twelve have none."""

GOOD = """\
name: cross
dof: [surge, sway, yaw]
frame: frd
T: [[1, 1, 0, 0], [0, 0, 1, 1], [-0.5, 0.5, 1, -1]]
f_min: -11
f_max: 11
"""
ACROSS = """\
name: across
dof: [surge]
T: [[1, 6.1e-17]]
f_min: -11
f_max: 11
"""
BOX = """\
name: box
dof: [surge, sway, yaw]
thrusters:
  - {position: [0.4, 0.3, 0], direction: [1, 0, 0]}
  - {position: [0.4, -0.3, 0], direction: [1, 0, 0]}
  - {position: [0.3, 0.1, 0], direction: [0, 1, 0]}
  - {position: [-0.3, 0.1, 0], direction: [0, 1, 0]}
center_of_mass: [0, 0, 0]
frame: frd
f_min: -11
f_max: 11
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "my.yaml"


def checked(file: Path, text: str) -> Report:
    file.write_text(text)
    return check_vehicle(file)


def messages(report: Report, level: Level) -> list[str]:
    return [finding.message for finding in report.findings if finding.level == level]


def thrustbench(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "bench", *map(str, arguments), "--no-picture"]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, cwd=ROOT)


@pytest.mark.parametrize("path", sorted(PUBLISHED.glob("*.yaml")), ids=lambda path: path.stem)
def test_a_published_vehicle_is_refused_for_its_known_defects_and_for_nothing_else(path: Path) -> None:
    report = check_vehicle(path)
    errors = messages(report, "error")
    assert bool(errors) == (path.stem in DEFECTS)
    remarks = "\n".join(errors + messages(report, "warning"))
    for defect in DEFECTS.get(path.stem, []):
        assert defect in remarks


def test_the_folder_holds_twelve_published_vehicles_and_those_with_defects_among_them() -> None:
    names = {path.stem for path in PUBLISHED.glob("*.yaml")}
    assert len(names) == 12
    assert set(DEFECTS) < names


@pytest.mark.parametrize("name", list_vehicles())
def test_a_shipped_vehicle_has_no_errors(name: str) -> None:
    report = check_vehicle(name)
    assert not messages(report, "error")
    assert report.facts is not None
    assert report.facts.condition < 4


def test_a_sound_file_gets_only_the_notes_on_what_failures_cost(file: Path) -> None:
    """Yaw alone takes each pair apart: 2 x 0.5 x 11 N m by thrusters 0 and 1, 2 x 11 N m by 2 and 3."""
    report = checked(file, GOOD)
    assert messages(report, "error") == messages(report, "warning") == []
    assert messages(report, "note") == [
        "without thruster 0 or 1: surge 50 %, yaw 67 % of the range left",
        "without thruster 2 or 3: sway 50 %, yaw 33 % of the range left",
    ]


@pytest.mark.parametrize(
    ("text", "level", "line", "says"),
    [
        (GOOD.replace("[0, 0, 1, 1]", "[0, 0, 0, 0]"), "error", None, "T has rank 2 but 3"),
        (GOOD.replace("[0, 0, 1, 1]", "[0, 0, 0, 0]"), "error", None, "(no thruster pushes sway)"),
        (GOOD.replace("[0, 0, 1, 1]", "[0, 0, 0, 0]") + "rank: 2\n", "warning", 4, "no thruster pushes sway"),
        (GOOD.replace("[0, 0, 1, 1]", "[1, 1, 0.02, 0]"), "warning", 4, "close to losing a direction"),
        (GOOD.replace("1, 1, 0, 0", "1, 1, 0, 0, 0").replace("1, 1]", "1, 1, 0]"), "error", 4, "rows differ"),
        (
            GOOD.replace("0, 0]", "0, 0, 0]").replace("1, 1]", "1, 1, 0]").replace("-1]", "-1, 0]"),
            "warning",
            4,
            "thruster 4 moves no controlled DOF",
        ),
        (ACROSS, "warning", 3, "thruster 1 moves no controlled DOF"),
        (GOOD.replace("[1, 1, 0, 0]", "[1, 1, 4e-6, 0]"), "note", 4, "surge of thruster 2 is 4e-06; if an"),
        (
            BOX.replace("[1, 0, 0]", "[0.9999997, 8e-4, 0]"),
            "note",
            3,
            "sway of thruster 0 is 0.0008, and 1 more like it; if an angle was rounded, as 1.57",
        ),
        (GOOD.replace("frame: frd\n", ""), "note", None, "no 'frame' given"),
        (GOOD + "center_of_mass: [0, 0, 1]\n", "warning", 7, "has no effect without thrusters"),
        (GOOD.replace("-11", "12"), "error", 5, "f_min[0] = 12 exceeds f_max[0] = 11"),
        (
            GOOD.replace("-11", "[1, -1, -1, -1]"),
            "warning",
            5,
            "0 can't stop: 0 N is outside its limits; is a minus",
        ),
        (GOOD.replace("-11", "[11, -1, -1, -1]"), "warning", 6, "thruster 0 has f_min = f_max = 11 N"),
        (GOOD.replace("-11", "0"), "note", 5, "4 of 4 thrusters push one way only"),
        (GOOD.replace("-11", "0"), "warning", 5, "within the limits gives -surge, -sway, +yaw, -yaw alone"),
        (GOOD.replace("-11", "-9"), "note", 6, "not the same ahead and astern (-9 … 11 N)"),
        (GOOD.replace("-11", "-1"), "warning", 6, "thruster 0 has limits of -1 … 11 N; is one mistyped?"),
        (GOOD.replace("11", "40"), "note", 6, "40 N for every thruster is a round number"),
        (GOOD + "weights: [1, 1, 1, -1]\n", "error", 7, "give numbers above 0"),
        (GOOD + "weights: [1, 1, 1, 1e6]\n", "warning", 7, "differ by a factor of 1e+06"),
        (BOX.replace("center_of_mass: [0, 0, 0]\n", ""), "note", None, "moments are taken about the origin"),
        (
            BOX.replace("center_of_mass: [0, 0, 0]", "center_of_mass: [-15, 1, 9]"),
            "warning",
            8,
            "outside the",
        ),
        (BOX.replace("0.4", "400"), "warning", 3, "over 100 m off"),
        (BOX.replace("-0.3, 0]", "0.3, 0]"), "warning", 5, "the same position and direction as thruster 0"),
        (BOX.replace("[1, 0, 0]", "[1, 1, 0]"), "error", 4, "has length 1.414; give a unit vector"),
        (BOX.replace("surge, sway", "surge, heave, sway"), "error", None, "(no thruster pushes heave)"),
        (
            BOX.replace("  - {position: [-0.3, 0.1", "# "),
            "warning",
            None,
            "without thruster 2: no sway",
        ),
        ("name: x\n", "error", None, "key 'dof' is missing"),
        (GOOD + "fmin: 1\n", "error", 7, "unknown key 'fmin'"),
        ("name: x\n[", "error", 2, "not valid YAML"),
    ],
)
def test_a_flaw_gets_its_remark_with_level_and_line(
    file: Path, text: str, level: str, line: int | None, says: str
) -> None:
    report = checked(file, text)
    matching = [finding for finding in report.findings if says in finding.message]
    assert matching, report.findings
    assert matching[0].level == level
    assert matching[0].line == line
    assert not matching[0].message.startswith(matching[0].key or ":")  # the key is said once


def test_a_failure_that_all_but_loses_a_direction_is_named(file: Path) -> None:
    weak = GOOD.replace("[0, 0, 1, 1]", "[0.01, -0.01, 0, 1]").replace("1, -1]", "0, 0]")
    warnings = messages(checked(file, weak), "warning")
    assert any("without thruster 2" in line or "without thruster 3" in line for line in warnings)
    near = GOOD.replace("[1, 1, 0, 0]", "[1, 0.04, 0, 0]")
    assert any("a direction is all but lost" in line for line in messages(checked(file, near), "warning"))
    nearer = GOOD.replace("[1, 1, 0, 0]", "[1, 0.02, 0, 0]")  # what a survey of 1 % all but makes of nothing
    assert any("surge counted by 31 %" in line for line in messages(checked(file, nearer), "warning"))


def test_a_vehicle_of_one_thruster_is_usable_and_warned_of_its_failure(file: Path) -> None:
    report = checked(file, "name: a\ndof: [surge]\nT: [[1]]\nf_min: -3\nf_max: 4\n")
    assert not messages(report, "error")
    assert any("no thruster is left" in line for line in messages(report, "warning"))


def test_the_command_exits_with_0_for_a_sound_file_and_prints_its_facts() -> None:
    run = thrustbench("check", "ukwial")
    assert run.returncode == 0
    assert run.stdout.startswith("ukwial: 3 DOF, 4 thrusters, rank 3, d = 1, condition 1,")
    assert "0 errors" in run.stdout.splitlines()[-1]
    assert not run.stderr


def test_the_command_exits_with_2_and_one_line_for_a_bad_file(file: Path) -> None:
    file.write_text(GOOD.replace("-11", "12"))
    run = thrustbench("check", file)
    assert run.returncode == 2
    assert run.stderr == f"thrustbench: {file}, line 5: cross: f_min[0] = 12 exceeds f_max[0] = 11\n"


@pytest.mark.parametrize(("text", "usable"), [(GOOD, True), (GOOD + "H: [[1]]\n", False), ("[", False)])
def test_json_tells_whether_the_file_is_usable_and_why_not(file: Path, text: str, usable: bool) -> None:
    file.write_text(text)
    run = thrustbench("check", file, "--json")
    report = json.loads(run.stdout)
    assert report["usable"] is usable
    assert (run.returncode == 0) is usable
    assert report["file"] == str(file)
    assert (report["facts"] is None) is not usable
    assert ("error" in {finding["level"] for finding in report["findings"]}) is not usable


def test_a_missing_file_is_refused_in_one_line() -> None:
    run = thrustbench("check", "/no/such.yaml")
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert "Traceback" not in run.stderr


def test_what_the_lowest_voltage_and_slew_rates_leave_is_said(tmp_path: Path) -> None:
    file = tmp_path / "slow.yaml"
    keys = "f_min: -50\nf_max: 60\nslew: {up: 30, down: 60}\nvolts: {12: [-20, 25], 16: [-40, 55]}\n"
    file.write_text(f"name: slow\ndof: [surge]\nframe: frd\nT: [[1, 1]]\n{keys}", encoding="utf-8")
    remarks = {(finding.level, finding.key, finding.message) for finding in check_vehicle(file).findings}
    assert ("note", "volts", "at 12 V thruster 0 gives -20 … 25 N of -50 … 60 N") in remarks
    assert ("note", "slew", "from 0 N to f_max the slowest thruster takes 2 s") in remarks
    short = "thruster 0 gives 55 N at most by 'volts', less than f_max = 60 N (and 1 more)"
    assert ("warning", "f_max", short) in remarks


def test_a_curve_s_end_that_differs_in_its_fourth_digit_is_the_limit(tmp_path: Path) -> None:
    file = tmp_path / "rounded.yaml"
    keys = "f_min: -50\nf_max: 51.4849\nvolts: {12: [-20, 25], 16: [-50, 51.4]}\n"
    file.write_text(f"name: slow\ndof: [surge]\nframe: frd\nT: [[1, 1]]\n{keys}", encoding="utf-8")
    assert not [finding for finding in check_vehicle(file).findings if "at most by" in finding.message]


def test_a_voltage_at_which_no_thruster_can_stop_is_warned_of_once(tmp_path: Path) -> None:
    file = tmp_path / "minus.yaml"
    keys = "f_min: -50\nf_max: 60\nvolts: {12: [20, 25], 16: [-50, 60]}\n"
    file.write_text(f"name: slow\ndof: [surge]\nframe: frd\nT: [[1, 1]]\n{keys}", encoding="utf-8")
    remarks = [finding.message for finding in check_vehicle(file).findings if finding.level == "warning"]
    assert remarks == ["at 12 V thruster 0 can't stop: 0 N is outside 20 … 25 N; is a minus missing?"]


def test_limits_by_the_voltages_of_a_curve_are_told_under_the_key_that_has_them(tmp_path: Path) -> None:
    file = tmp_path / "curve.yaml"
    curve = "{12: [[-100, -20], [0, 0], [100, 25]], 16: [[-100, -40], [0, 0], [100, 55]]}"
    keys = f"f_min: -40\nf_max: 55\nesc: {{neutral: 0, range: [-100, 100], curve: {curve}}}\n"
    file.write_text(f"name: slow\ndof: [surge]\nframe: frd\nT: [[1, 1]]\n{keys}", encoding="utf-8")
    remarks = {(finding.key, finding.message) for finding in check_vehicle(file).findings}
    assert ("esc", "at 12 V thruster 0 gives -20 … 25 N of -40 … 55 N") in remarks


def test_a_file_with_the_name_of_a_shipped_vehicle_is_told_so_and_the_shipped_one_is_not(file: Path) -> None:
    said = "ukwial is a shipped vehicle, too; with another name tables tell them apart"
    assert said in messages(checked(file, GOOD.replace("name: ", "name: ukwial # ")), "note")
    assert said not in messages(check_vehicle("ukwial"), "note")


def test_a_key_stands_once_in_front_of_its_remark(file: Path) -> None:
    twice = as_table(checked(file, GOOD + "names: [a, b, c, a]\n"))
    assert "names: 'a' stands twice" in twice
    assert "names: names" not in twice


PAIRS = """\
name: pairs
dof: [surge, sway, heave, roll, yaw]
frame: frd
thrusters:
  - {name: bow right, position: [0.2, 0.15, 0], direction: [0.6, -0.8, 0]}
  - {name: bow left, position: [0.2, -0.15, 0], direction: [0.6, 0.8, 0]}
  - {name: stern right, position: [-0.2, 0.15, 0], direction: [0.6, 0.8, 0]}
  - {name: stern left, position: [-0.2, -0.15, 0], direction: [0.6, -0.8, 0]}
  - {name: down right, position: [0, 0.12, 0], direction: [0, 0, 1]}
  - {name: down left, position: [0, -0.12, 0], direction: [0, 0, 1]}
center_of_mass: [0, 0, 0]
f_min: -41
f_max: 41
"""


def test_failures_are_told_by_the_thrusters_names_and_each_cost_once(file: Path) -> None:
    """One vertical thruster can't give heave and roll each by itself; its pair is of one kind with it."""
    report = checked(file, PAIRS)
    assert messages(report, "warning") == [
        "without down right or down left: no heave and roll together",
    ]
    assert [failure.lost for failure in report.failures if failure.lost] == [(("heave", "roll"),)] * 2
    (cost,) = [line for line in messages(report, "note") if line.startswith("without bow right, bow left")]
    assert cost.endswith("surge 50 %, sway 50 %, yaw 50 % of the range left")


def test_a_direction_that_the_whole_vehicle_lacks_is_no_cost_of_a_failure(file: Path) -> None:
    report = checked(file, PAIRS.replace("roll, yaw]", "roll, pitch, yaw]") + "rank: 5\n")
    assert {failure.lost for failure in report.failures} == {(), (("heave", "roll"),)}


def test_a_thruster_that_points_against_its_mirror_image_is_named(file: Path) -> None:
    """Thrusters that push straight to a side have no wrong way: there people mirror them, or do not."""
    for name, reversed_ in (("stern left", "[-0.6, 0.8, 0]"), ("down left", "[0, 0, -1]")):
        sound = next(line for line in PAIRS.splitlines() if name in line)
        wrong = sound.partition("direction")[0] + f"direction: {reversed_}}}"
        found = [f for f in checked(file, PAIRS.replace(sound, wrong)).findings if "reversed?" in f.message]
        assert [(f.level, f.line) for f in found] == [("warning", PAIRS.splitlines().index(sound) + 1)]
        assert name in found[0].message
    assert not any("reversed?" in line for line in messages(checked(file, PAIRS), "warning"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (GOOD.replace("11", "0.25"), "multiply f_min and f_max"),
        (GOOD.replace("11", "1"), "a share of full throttle"),
        (GOOD.replace("11", "4e7"), "mN? divide by 1000"),
        (GOOD.replace("[-0.5, 0.5, 1, -1]", "[-500, 500, 1000, -1000]"), "an arm is 1000 m long; mm?"),
        (
            GOOD.replace("[-0.5, 0.5, 1, -1]", "[-25, 25, 30, -30]"),
            "an arm is 30 m long, and no thruster gives",
        ),
        (GOOD.replace("[-0.5, 0.5, 1, -1]", "[-0.5e-3, 0.5e-3, 1e-3, -1e-3]"), "longest arm is 0.001 m; km?"),
    ],
)
def test_units_that_can_t_be_right_are_said_with_their_factor(file: Path, text: str, says: str) -> None:
    assert any(says in line for line in messages(checked(file, text), "warning"))
    assert not any(says in line for line in messages(checked(file, GOOD), "warning"))
