"""Other people's files made into vehicle files, with what was assumed; and back."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError, Vehicle, list_vehicles, load_vehicle
from alloc.vehicle.file import VehicleFile, build_vehicle
from alloc.vehicle.geometry import DOF, from_flu
from alloc.vehicle.read import find_file, read_document
from alloc.vehicle.text import to_yaml
from bench.inputs.formats import formats, writable
from bench.inputs.imported import ImportOptions, import_vehicle
from tests.places import ROOT

LIMITS = ImportOptions(f_min=-20, f_max=20)

NAUTILUS = """\
/**:
  ros__parameters:
    physical:
      center_of_mass: [0.0, 0.0, 0.01]
    propulsion:
      dofs: {num: 6}
      thrusters:
        num: 8
        thruster_force_direction: [0.70711, 0.0, 0.0, -0.70711, -0.70711, 0.0, 0.0, 0.70711,
          -0.70711, 0.0, 0.0, -0.70711, 0.70711, 0.0, 0.0, 0.70711, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0]
        thruster_position: [0.413892, 0.140095, -0.163904, -0.413892, -0.413892, -0.163904, 0.140095,
          0.413892, 0.313022, 0.313022, 0.313022, 0.313022, -0.313022, -0.313022, -0.313022, -0.313022,
          0.021736, 0.021736, 0.021736, 0.021736, 0.021736, 0.021736, 0.021736, 0.021736]
        constraints:
          max_force: 40.0
          min_force: -40.0
          input_matrix_weights: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
          slack_matrix_weights: [2000.0, 2000.0, 2000.0, 2000.0, 2000.0, 2000.0]
"""
MAELSTROM = """\
propulsion:
  dofs:
    num: 5
    which: {surge: true, sway: true, heave: true, roll: false, pitch: true, yaw: true}
  thrusters:
    num: 6
    configuration_matrix:
      [[0.7071, 0.7071, -0.7071, -0.7071, 0.0, 0.0],
       [0.7071, -0.7071, -0.7071, 0.7071, 0.0, 0.0],
       [0.0, 0.0, 0.0, 0.0, 1.0, 1.0],
       [-0.0467, -0.0467, 0.0467, 0.0467, -0.1600, 0.1600],
       [0.2143, -0.2143, 0.2143, -0.2143, 0.0, 0.0]]
"""
MANTA = """\
physical:
  center_of_mass: [0, 0, 0]
  thruster_layout: [[-0.70711, 0.70711, 0], [0, 0, 1], [0, 0, 1], [-0.70711, -0.70711, 0],
    [0.70711, -0.70711, 0], [0, 0, 1], [0, 0, 1], [0.70711, 0.70711, 0]]
  thruster_positions: [[0.20506, 0.20506, 0], [0.1207, 0.1207, 0], [0.1207, -0.1207, 0], [0.20506, -0.20506,
    0], [-0.20506, -0.20506, 0], [-0.1207, -0.1207, 0], [-0.1207, 0.1207, 0], [-0.20506, 0.20506, 0]]
propulsion:
  thrusters:
    num: 8
    configuration_matrix:
      [[0.70711, 0, 0, -0.70711, -0.70711, 0, 0, 0.70711], [0.70711, 0, 0, 0.70711, -0.70711, 0, 0, -0.70711],
       [0, -1, -1, 0, 0, -1, -1, 0], [0, 0.12, 0.12, 0, 0, -0.12, -0.12, 0],
       [0, 0.12, -0.12, 0, 0, -0.12, 0.12, 0], [0.29, 0, 0, -0.29, 0.29, 0, 0, -0.29]]
    characteristics:
      thrust: [-12.0, -0.0001, 0.0001, 12.0]
"""
TAM = """\
tam:
- [-0.9999999999964795, -0.9999999999964795, 0.0]
- [0.0, 0.0, 0.0]
- [0.0, 0.0, 0.9999999999991198]
- [0.0, 0.0, 0.0]
- [-0.006182799999978233, -0.006182799999978233, 0.06699983306632216]
- [-0.11919976648567758, 0.11920023351348312, 0.0]
"""
HEXA = """\
#!/bin/sh
# CA_ROTOR9_PX 5 in a comment is no parameter
param set-default CA_ROTOR_COUNT 6
param set-default CA_ROTOR0_PY 0.5
param set-default CA_ROTOR0_KM -0.05
param set-default CA_ROTOR1_PY -0.5
param set-default CA_ROTOR2_PX 0.43
param set-default CA_ROTOR2_PY -0.25
param set-default CA_ROTOR2_KM -0.05
param set-default CA_ROTOR3_PX -0.43
param set-default CA_ROTOR3_PY 0.25
param set-default CA_ROTOR4_PX 0.43
param set-default CA_ROTOR4_PY 0.25
param set-default CA_ROTOR5_PX -0.43
param set-default CA_ROTOR5_PY -0.25
param set-default CA_ROTOR5_KM -0.05
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "theirs.yaml"


def imported(file: Path, text: str, answers: ImportOptions | None = None) -> VehicleFile:
    file.write_text(text, encoding="utf-8")
    return import_vehicle(file, answers=answers)


def vehicle_of(keys: VehicleFile, file: Path) -> Vehicle:
    """The vehicle as it is read back from the file that would be written."""
    path = file.parent / "ours.yaml"
    path.write_text(to_yaml(keys), encoding="utf-8")
    return load_vehicle(path)


def test_ros_poses_give_the_shipped_nautilus(file: Path) -> None:
    keys = imported(file, NAUTILUS)
    vehicle, shipped = vehicle_of(keys, file), load_vehicle("nautilus")
    for key in ("T", "H", "f_min", "f_max", "slack_weights"):
        np.testing.assert_array_equal(getattr(vehicle, key), getattr(shipped, key))
    assert any("frame" in note for note in keys.notes)


@pytest.mark.parametrize("flat", [False, True], ids=["rows", "flat, as ROS 2 has it"])
def test_a_configuration_matrix_is_read_with_the_axes_its_file_names(file: Path, flat: bool) -> None:
    text = MAELSTROM
    if flat:
        head, matrix = MAELSTROM.split("configuration_matrix:")
        text = head + "configuration_matrix: [" + ", ".join(re.findall(r"-?\d\.\d+", matrix)) + "]\n"
    keys = imported(file, text, LIMITS)
    assert keys.dof == ["surge", "sway", "heave", "pitch", "yaw"]
    vehicle = vehicle_of(keys, file)
    assert vehicle.T[3].tolist() == [-0.0467, -0.0467, 0.0467, 0.0467, -0.16, 0.16]
    assert vehicle.rank == 5


def test_a_matrix_and_poses_that_contradict_are_refused_until_one_is_chosen(file: Path) -> None:
    with pytest.raises(AllocError, match="--take T or --take poses"):
        imported(file, MANTA)
    assert vehicle_of(imported(file, MANTA, ImportOptions(take="T")), file).T[2, 1] == -1
    keys = imported(file, MANTA, ImportOptions(take="poses"))
    assert vehicle_of(keys, file).T[2, 1] == 1
    assert keys.T is None
    assert (keys.f_min, keys.f_max) == (-12, 12)
    assert "Limits are the ends of characteristics.thrust." in keys.notes


def test_a_tam_is_turned_to_z_down_and_keeps_the_axes_it_can_control(file: Path) -> None:
    keys = imported(file, TAM, LIMITS)
    assert keys.dof == ["surge", "heave", "yaw"]
    said = " ".join(keys.notes)
    for axis in ("sway", "roll", "pitch"):
        assert f"{axis} is left out of dof" in said
    vehicle = vehicle_of(keys, file)
    np.testing.assert_allclose(vehicle.T, [[-1, -1, 0], [0, 0, -1], [0.1192, -0.1192, 0]], rtol=0, atol=1e-6)


def test_what_is_independent_in_the_last_printed_digit_only_is_rounding(tmp_path: Path) -> None:
    """A BlueROV2's six axes to three decimals: pitch follows surge, but for the third one."""
    text = """\
surge,0.707,0.707,0.707,0.707,0,0
sway,0.707,-0.707,-0.707,0.707,0,0
heave,0,0,0,0,1,-1
roll,0.051,-0.051,-0.051,0.051,-0.111,-0.111
pitch,-0.051,-0.051,-0.052,-0.051,-0.003,0.003
yaw,0.167,-0.167,0.175,-0.175,0,0
"""
    keys = imported(tmp_path / "T.csv", text, LIMITS)
    assert keys.dof == ["surge", "sway", "heave", "roll", "yaw"]


def test_px4_rotors_with_their_defaults(file: Path) -> None:
    """Roll, pitch, yaw and thrust of PX4's hexarotor x, as PX4 works them out."""
    keys = imported(file, HEXA)
    assert keys.dof == ["heave", "roll", "pitch", "yaw"]
    expected = [
        [-1, -1, -1, -1, -1, -1],
        [-0.5, 0.5, 0.25, -0.25, -0.25, 0.25],
        [0, 0, 0.43, -0.43, 0.43, -0.43],
        [-0.05, 0.05, -0.05, 0.05, 0.05, -0.05],
    ]
    vehicle = vehicle_of(keys, file)
    np.testing.assert_allclose(vehicle.T, expected, atol=1e-15)
    assert (vehicle.f_min.tolist(), vehicle.f_max.tolist()) == ([0] * 6, [1] * 6)
    assert any("PX4's default" in note for note in keys.notes)
    assert any("normalised" in note for note in keys.notes)


def test_px4_axes_coefficients_and_reversible_rotors_from_a_params_file(file: Path) -> None:
    rotors = {0: (1, 0, 0, 0.3), 1: (1, 0, 0, -0.3), 2: (0, 3, 0, 0.0)}  # the last axis is not of length 1
    lines = [
        "# Vehicle-Id Component-Id Name Value Type",
        "1\t1\tCA_ROTOR_COUNT\t3\t6",
        "1\t1\tCA_R_REV\t3\t6",
    ]
    for i, (x, y, z, arm) in rotors.items():
        values = {"AX": x, "AY": y, "AZ": z, "PY": arm, "KM": 0, "CT": 10 + i}
        lines += [f"1\t1\tCA_ROTOR{i}_{key}\t{value}\t9" for key, value in values.items()]
    vehicle = vehicle_of(imported(file, "\n".join(lines)), file)
    assert vehicle.dof == ("surge", "sway", "yaw")
    np.testing.assert_array_equal(vehicle.T, [[1, 1, 0], [0, 0, 1], [-0.3, 0.3, 0]])
    assert vehicle.f_max.tolist() == [10, 11, 12]
    assert vehicle.f_min.tolist() == [-10, -11, 0]


@pytest.mark.parametrize(
    "text",
    [
        "surge,1,1,0\nsway,0,0,1\nyaw,-0.3,0.3,1e-5\n",
        "dof,f0,f1,f2\nyaw,-0.3,0.3,1e-5\nsurge,1,1,0\nsway,0,0,1\n",
        "\ufeff1,1,0\r\n0,0,1\r\n-0.3,0.3,1e-5\r\n",
        "a, b, c\n1, 1, 0\n0, 0, 1\n-0.3, 0.3, 1e-5\n",
    ],
    ids=["names", "header, other order", "bare", "header, bare"],
)
def test_a_csv_of_t_in_its_spellings(tmp_path: Path, text: str) -> None:
    vehicle = vehicle_of(imported(tmp_path / "T.csv", text, LIMITS), tmp_path / "T.csv")
    rows = dict(zip(vehicle.dof, vehicle.T.tolist(), strict=True))
    assert rows == {"surge": [1, 1, 0], "sway": [0, 0, 1], "yaw": [-0.3, 0.3, 1e-5]}


@pytest.mark.parametrize(
    ("text", "answers", "says"),
    [
        (MAELSTROM, ImportOptions(), "no limits in it; give --f-min and --f-max"),
        (MAELSTROM, ImportOptions(dof=("roll",), f_min=-1, f_max=1), "no row for 'roll'"),
        (MAELSTROM.replace("which", "what"), LIMITS, "5 rows without names; name them with --dof"),
        (MAELSTROM.replace("0.2143, -0.2143, 0.2143, -0.2143", "0.2143"), LIMITS, "differ in length"),
        (
            MAELSTROM.replace("0.7071, 0.7071, -0.7071", "fast, 0.7071, -0.7071"),
            LIMITS,
            "not made of numbers",
        ),
        (NAUTILUS.replace("40.0", "strong"), ImportOptions(), "min_force is not made of numbers"),
        (
            NAUTILUS.replace("thruster_position", "place"),
            ImportOptions(),
            "has only one of thruster_position and",
        ),
        (NAUTILUS.replace("[0.413892,", "["), ImportOptions(), "thruster_position has 23 numbers"),
        (NAUTILUS.replace("2000.0, 2000.0, ", ""), ImportOptions(), "slack_weights has 2 entries for 6 DOF"),
        (TAM.replace("- [0.0, 0.0, 0.0]\n", ""), LIMITS, "tam has 4 rows; give six"),
        (HEXA.replace("COUNT 6", "COUNT 99"), ImportOptions(), "CA_ROTOR_COUNT is 99"),
        (HEXA.replace("0.43", "far"), ImportOptions(), "CA_ROTOR2_PX is 'far'; give a number"),
        (
            HEXA.replace("0.43", "1e400"),
            ImportOptions(),
            "line 7: CA_ROTOR2_PX is '1e400'; give a finite number",
        ),
        (HEXA + "param set CA_ROTOR0_AZ 0\n", ImportOptions(), "CA_ROTOR0_AX, AY, AZ are all 0"),
        ("hello: 1\n", LIMITS, "none of the known formats"),
        ("", LIMITS, "none of the known formats"),
    ],
)
def test_what_is_missing_or_wrong_is_named(file: Path, text: str, answers: ImportOptions, says: str) -> None:
    with pytest.raises(AllocError) as caught:
        imported(file, text, answers)
    message = str(caught.value)
    assert says in message
    assert message.startswith(str(file))
    assert "\n" not in message


@pytest.mark.parametrize("text", ["", "x\n", "1,2\n3\n", "surge,1\nsway,\n", "1\n2\n3\n4\n", "surge,nan\n"])
def test_a_bad_csv_of_t_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(AllocError, match=r"T\.csv: "):
        imported(tmp_path / "T.csv", text, LIMITS)


@pytest.mark.parametrize("name", list_vehicles())
def test_a_vehicle_exported_to_ros_comes_back_the_same(tmp_path: Path, name: str) -> None:
    keys = read_document(find_file(name)).keys
    vehicle = build_vehicle(keys)
    path = tmp_path / "params.yaml"
    back = vehicle_of(imported(path, formats()["ros"].write(keys, vehicle)), path)
    assert back.dof == vehicle.dof
    for key in ("T", "H", "f_min", "f_max", "slack_weights"):
        np.testing.assert_allclose(getattr(back, key), getattr(vehicle, key), rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize("name", list_vehicles())
def test_a_vehicle_exported_to_csv_comes_back_with_the_same_matrix(tmp_path: Path, name: str) -> None:
    keys = read_document(find_file(name)).keys
    vehicle = build_vehicle(keys)
    back = imported(tmp_path / "T.csv", formats()["csv"].write(keys, vehicle), LIMITS)
    assert tuple(back.dof) == vehicle.dof
    np.testing.assert_array_equal(np.array(back.T), vehicle.T)


@pytest.mark.parametrize("name", list_vehicles())
def test_a_vehicle_file_written_anew_reads_the_same(tmp_path: Path, name: str) -> None:
    keys = read_document(find_file(name)).keys
    path = tmp_path / "again.yaml"
    path.write_text(to_yaml(keys), encoding="utf-8")
    assert read_document(path).keys == keys


@pytest.mark.parametrize(
    "text", ["yes", "a: b", "#1", "", "1e5", "tab\there", "ü ü", "[x]", "- x", "'q'", "a\nb"]
)
def test_any_text_survives_being_written(tmp_path: Path, text: str) -> None:
    keys = read_document(find_file("ukwial")).keys
    keys.source, keys.notes = text, [text]
    path = tmp_path / "again.yaml"
    path.write_text(to_yaml(keys), encoding="utf-8")
    assert read_document(path).keys == keys


def test_a_full_h_can_not_be_told_to_ros() -> None:
    keys = read_document(find_file("ukwial")).keys
    keys.H = (np.eye(4) + 0.1).tolist()
    with pytest.raises(AllocError, match="H is not diagonal"):
        formats()["ros"].write(keys, build_vehicle(keys))


def test_the_frame_told_by_hand_turns_the_vehicle(tmp_path: Path) -> None:
    text = "\n".join(",".join(map(str, row)) for row in np.eye(6).tolist())
    here = vehicle_of(imported(tmp_path / "T.csv", text, LIMITS), tmp_path / "T.csv")
    there_keys = imported(tmp_path / "T.csv", text, ImportOptions(frame="flu", f_min=-20, f_max=20))
    np.testing.assert_array_equal(vehicle_of(there_keys, tmp_path / "T.csv").T, from_flu(here.T, DOF))
    assert "The frame is flu, as told." in there_keys.notes


def thrustbench(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "bench", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, cwd=ROOT)


def test_the_commands_import_check_and_export(tmp_path: Path) -> None:
    (tmp_path / "TAM.yaml").write_text(TAM)
    ours = tmp_path / "ours.yaml"
    run = thrustbench("import", tmp_path / "TAM.yaml", "--f-min=-20", "--f-max=20", "--name=saga", "-o", ours)
    assert run.returncode == 0, run.stderr
    assert "assumed: The frame is base_link" in run.stderr
    assert thrustbench("check", ours).returncode == 0
    run = thrustbench("export", ours, "--format", "csv")
    assert run.stdout.splitlines()[0] == "dof,f0,f1,f2"
    assert thrustbench("export", ours, "--format", "px4").returncode == 2
    assert set(writable()) == {"csv", "ros"}


def test_a_file_without_limits_ends_with_2_and_nothing_written(tmp_path: Path) -> None:
    (tmp_path / "TAM.yaml").write_text(TAM)
    run = thrustbench("import", tmp_path / "TAM.yaml", "-o", tmp_path / "ours.yaml")
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert not (tmp_path / "ours.yaml").exists()
