"""Files of other projects made into vehicle files, with what was assumed."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError, load_vehicle
from alloc.errors import FileError, VehicleError
from alloc.vehicle.keys import to_yaml
from bench.inputs.formats import csv, writable
from bench.inputs.imported import ImportOptions
from tests.foreign_vehicles import LIMITS, imported, vehicle_of
from tests.places import ROOT
from tests.readers import refused

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


def test_ros_poses_give_the_shipped_nautilus(tmp_path: Path) -> None:
    keys = imported(tmp_path, NAUTILUS)
    vehicle, shipped = vehicle_of(keys, tmp_path), load_vehicle("nautilus")
    for key in ("T", "H", "f_min", "f_max", "slack_weights"):
        np.testing.assert_array_equal(getattr(vehicle, key), getattr(shipped, key))
    assert any("frame" in note for note in keys.notes)


def test_parameters_of_two_nodes_are_not_mixed(tmp_path: Path) -> None:
    """The first one's matrix got the second one's limits."""
    node = "/{}/allocator:\n  ros__parameters:\n    configuration_matrix: [1.0, 1.0]\n    dof: [surge]\n"
    both = r"below '/rov1/allocator\.ros__parameters' and '/rov2/allocator\.ros__parameters'; keep one"
    with pytest.raises(VehicleError, match=both):
        imported(tmp_path, node.format("rov1") + node.format("rov2"))


def test_another_node_s_limits_are_not_the_thrusters(tmp_path: Path) -> None:
    own = "/rov/allocator:\n  ros__parameters:\n    configuration_matrix: [[1.0, 1.0]]\n    dof: [surge]\n"
    own += "    constraints: {min_force: [-9.0, -9.0], max_force: [9.0, 9.0]}\n"
    guidance = "/rov/guidance:\n  ros__parameters: {min_force: -1.0, max_force: 1.0}\n"
    for text in (guidance + own, own + guidance):
        keys = imported(tmp_path, text, ImportOptions(dof=["surge"]))
        assert (keys.f_min, keys.f_max) == ([-9, -9], [9, 9])


@pytest.mark.parametrize("flat", [False, True], ids=["rows", "flat, as ROS 2 has it"])
def test_a_configuration_matrix_is_read_with_the_axes_its_file_names(tmp_path: Path, flat: bool) -> None:
    text = MAELSTROM
    if flat:
        head, matrix = MAELSTROM.split("configuration_matrix:")
        text = head + "configuration_matrix: [" + ", ".join(re.findall(r"-?\d\.\d+", matrix)) + "]\n"
    keys = imported(tmp_path, text, LIMITS)
    assert keys.dof == ["surge", "sway", "heave", "pitch", "yaw"]
    vehicle = vehicle_of(keys, tmp_path)
    assert vehicle.T[3].tolist() == [-0.0467, -0.0467, 0.0467, 0.0467, -0.16, 0.16]
    assert vehicle.rank == 5


def test_a_matrix_and_poses_that_contradict_are_refused_until_one_is_chosen(tmp_path: Path) -> None:
    with pytest.raises(AllocError, match="--take T or --take poses"):
        imported(tmp_path, MANTA)
    assert vehicle_of(imported(tmp_path, MANTA, ImportOptions(take="T")), tmp_path).T[2, 1] == -1
    keys = imported(tmp_path, MANTA, ImportOptions(take="poses"))
    assert vehicle_of(keys, tmp_path).T[2, 1] == 1
    assert keys.T is None
    assert (keys.f_min, keys.f_max) == (-12, 12)
    assert "Limits are the ends of characteristics.thrust." in keys.notes


def test_a_tam_keeps_its_frame_z_up_and_the_axes_it_can_control(tmp_path: Path) -> None:
    keys = imported(tmp_path, TAM, LIMITS)
    assert keys.dof == ["surge", "heave", "yaw"]
    notes = " ".join(keys.notes)
    for axis in ("sway", "roll", "pitch"):
        assert f"{axis} is left out of dof" in notes
    vehicle = vehicle_of(keys, tmp_path)
    assert vehicle.frame == "flu"
    np.testing.assert_allclose(vehicle.T, [[-1, -1, 0], [0, 0, 1], [-0.1192, 0.1192, 0]], rtol=0, atol=1e-6)


def test_a_row_independent_only_in_its_last_printed_digit_is_left_out(tmp_path: Path) -> None:
    """A BlueROV2's six axes to three decimals: pitch follows surge, but for the third one."""
    text = """\
surge,0.707,0.707,0.707,0.707,0,0
sway,0.707,-0.707,-0.707,0.707,0,0
heave,0,0,0,0,1,-1
roll,0.051,-0.051,-0.051,0.051,-0.111,-0.111
pitch,-0.051,-0.051,-0.052,-0.051,-0.003,0.003
yaw,0.167,-0.167,0.175,-0.175,0,0
"""
    keys = imported(tmp_path, text, LIMITS, "T.csv")
    assert keys.dof == ["surge", "sway", "heave", "roll", "yaw"]


@pytest.mark.parametrize(
    "text",
    [
        "surge,1,1,0\nsway,0,0,1\nyaw,-0.3,0.3,1e-5\n",
        "dof,f0,f1,f2\nyaw,-0.3,0.3,1e-5\nsurge,1,1,0\nsway,0,0,1\n",
        "\ufeff1,1,0\r\n0,0,1\r\n-0.3,0.3,1e-5\r\n",
        "a, b, c\n1, 1, 0\n0, 0, 1\n-0.3, 0.3, 1e-5\n",
        "surge;1,0;1,0;0\nsway;0;0;1\nyaw;-0,3;0,3;1e-5\n",
        ",0,1,2\nsurge,1,1,0\nsway,0,0,1\nyaw,-0.3,0.3,1e-5\n",
        "dof,1,2,3\nsurge,1,1,0\nsway,0,0,1\nyaw,-0.3,0.3,1e-5\n",
    ],
    ids=["names", "header, other order", "bare", "header, bare", "decimal commas", "pandas", "dof"],
)
def test_a_csv_of_t_is_read_with_and_without_names_and_header(tmp_path: Path, text: str) -> None:
    vehicle = vehicle_of(imported(tmp_path, text, LIMITS, "T.csv"), tmp_path)
    rows = dict(zip(vehicle.dof, vehicle.T.tolist(), strict=True))
    assert rows == {"surge": [1, 1, 0], "sway": [0, 0, 1], "yaw": [-0.3, 0.3, 1e-5]}


def test_a_t_with_a_row_for_each_thruster_is_told_so(tmp_path: Path) -> None:
    """The advice was to name eight rows, which six DOF can't."""
    with pytest.raises(
        VehicleError, match="8 rows without names; write a row for each DOF, not for each thr"
    ):
        imported(tmp_path, "1,0,0,0,0,1\n" * 8, LIMITS, "T.csv")


@pytest.mark.parametrize(
    ("text", "options", "says"),
    [
        (MAELSTROM, ImportOptions(), "no limits in it; give --f-min and --f-max"),
        (
            MAELSTROM,
            ImportOptions(dof=("roll",), f_min=-1, f_max=1),
            "dof: got 'roll', expected some of surge",
        ),
        (MAELSTROM.replace("which", "what"), LIMITS, "5 rows without names; name them with --dof"),
        (MAELSTROM.replace("0.2143, -0.2143, 0.2143, -0.2143", "0.2143"), LIMITS, "differ in length"),
        (
            MAELSTROM.replace("0.7071, 0.7071, -0.7071", "fast, 0.7071, -0.7071"),
            LIMITS,
            "got 'fast', expected a number such as 0.5 or -40",
        ),
        (NAUTILUS.replace("40.0", "strong"), ImportOptions(), "min_force: got '-strong', expected a number"),
        (
            NAUTILUS.replace("thruster_position", "place"),
            ImportOptions(),
            "thruster_position: got it or thruster_force_direction alone, expected both",
        ),
        (
            NAUTILUS.replace("[0.413892,", "["),
            ImportOptions(),
            "thruster_position: got 23 numbers, expected all x",
        ),
        (
            MAELSTROM.split("configuration_matrix:")[0] + "configuration_matrix: [1, 2, 3]\n",
            LIMITS,
            "configuration_matrix: got 3 numbers, expected 6 for each row",
        ),
        (
            NAUTILUS.replace("2000.0, 2000.0, ", ""),
            ImportOptions(),
            "slack_weights: got 2 entries, expected 6, one a DOF",
        ),
        (TAM.replace("- [0.0, 0.0, 0.0]\n", ""), LIMITS, "tam: got 4 rows, expected six"),
        ("hello: 1\n", LIMITS, "none of the known formats"),
        ("", LIMITS, "none of the known formats"),
    ],
)
def test_a_file_that_lacks_something_or_is_wrong_is_refused_with_what_it_lacks(
    tmp_path: Path, text: str, options: ImportOptions, says: str
) -> None:
    assert says in refused(lambda: imported(tmp_path, text, options), tmp_path / "theirs.yaml")


@pytest.mark.parametrize("text", ["", "x\n", "1,2\n3\n", "surge,1\nsway,\n", "1\n2\n3\n4\n", "surge,nan\n"])
def test_a_bad_csv_of_t_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(AllocError, match=r"T\.csv[:,] "):
        imported(tmp_path, text, LIMITS, "T.csv")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("surge,1,1\nsurge,0.5,-1\nyaw,0.2,-0.2\n", "line 2: surge stands twice; keep one of its rows"),
        (
            "surge,1,1\nsurgee,0,1\nyaw,0.2,-0.2\n",
            "line 2: 'surgee' is no DOF; begin the row with one of surge",
        ),
        (",f0,f1\n0,1,1\n1,0.2,-0.2\n", "line 2: '0' is no DOF"),
        ("surgee,1,2\nyaw,0.2,-0.2\n", "line 1: 'surgee' is no DOF"),
        ("0,1,2\n1,1,0\n0,0,1\n", "line 1: 0, 1, 2 may be a header or a row; name the rows"),
        ("1,2\n1,1\n0,0\n0.2,-0.2\n", "line 1: 1, 2 may be a header or a row; name the rows"),
        ("surge,sway,yaw\n1,0,0.2\n1,0,-0.2\n0,1,0\n", "line 1: surge stands in the header; give a row"),
        ("Fx,Fy,Mz\n1,0,0.2\n1,0,-0.2\n0,1,0\n", "line 1: Fx stands in the header; give a row"),
        ("X,Y,N\n1,0,0.2\n1,0,-0.2\n0,1,0\n", "line 1: X stands in the header; give a row"),
        (",force.x,force.y,torque.z\nT1,1,0,0.2\nT2,1,0,-0.2\n", "line 1: force.x stands in the header"),
    ],
)
def test_rows_of_a_csv_of_t_that_could_be_misread_are_refused_with_their_line(
    tmp_path: Path, text: str, says: str
) -> None:
    """A row that stood twice was left out as one that no thruster moves, a header's 0 and 1 were thrusts."""
    assert says in refused(lambda: imported(tmp_path, text, LIMITS, "T.csv"), tmp_path / "T.csv")


def test_a_given_frame_is_the_vehicle_s_and_turns_no_number(tmp_path: Path) -> None:
    text = "\n".join(",".join(map(str, row)) for row in np.eye(6).tolist())
    in_frd = vehicle_of(imported(tmp_path, text, LIMITS, "T.csv"), tmp_path)
    flu_keys = imported(tmp_path, text, ImportOptions(frame="flu", f_min=-20, f_max=20), "T.csv")
    in_flu = vehicle_of(flu_keys, tmp_path)
    assert (in_frd.frame, in_flu.frame) == ("frd", "flu")
    np.testing.assert_array_equal(in_flu.T, in_frd.T)
    assert "The frame is flu, as told." in flu_keys.notes


@pytest.mark.parametrize(
    ("comment", "told", "written"),
    [("# frame: frd\n", "", True), ("", "frd", True), ("# frame: flu\n", "", True), ("", "", False)],
)
def test_a_frame_that_was_said_stands_in_the_vehicle_s_file(
    comment: str, told: str, written: bool, tmp_path: Path
) -> None:
    options = ImportOptions(frame=told, f_min=-20, f_max=20)
    text = comment + "\n".join(",".join(map(str, row)) for row in np.eye(6).tolist())
    keys = imported(tmp_path, text, options, "T.csv")
    taken = vehicle_of(keys, tmp_path).frame
    assert (f"\nframe: {taken}\n" in to_yaml(keys)) == written


def test_an_axis_that_is_none_is_refused_in_words(tmp_path: Path) -> None:
    message = refused(
        lambda: imported(
            tmp_path,
            "1,1,0,0\n0,0,1,1\n1,-1,1,-1\n",
            ImportOptions(dof=("surge", "pich", "yaw"), f_min=-1, f_max=1),
            "T.csv",
        ),
        tmp_path / "T.csv",
    )
    assert message.endswith(
        "T.csv: dof[1]: got 'pich', expected one of heave, pitch, roll, surge, sway, yaw;"
        " docs/your-vehicle.md shows the form"
    )


def thrustbench(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "bench", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, cwd=ROOT)


def test_the_commands_import_check_and_export(tmp_path: Path) -> None:
    (tmp_path / "TAM.yaml").write_text(TAM)
    ours = tmp_path / "ours.yaml"
    run = thrustbench("import", tmp_path / "TAM.yaml", "--f-min=-20", "--f-max=20", "--name=saga", "-o", ours)
    assert run.returncode == 0, run.stderr
    assert "assumed: The frame is base_link" in run.stderr
    assert thrustbench("check", ours, "--no-picture").returncode == 0
    run = thrustbench("export", ours, "--format", "csv")
    assert run.stdout.splitlines()[:2] == ["# frame: flu (x ahead, y to port, z up)", "dof,f0,f1,f2"]
    assert "CA_ROTOR_COUNT\t3" in thrustbench("export", ours, "--format", "px4").stdout
    assert thrustbench("export", ours, "--format", "urdf").returncode == 2
    assert set(writable()) == {"csv", "ros", "px4", "ardusub-matrix"}


AUV_CONTROLLERS = """\
thruster_allocation_matrix_controller:
  ros__parameters:
    thrusters: [thruster1_joint, thruster2_joint, thruster3_joint, thruster4_joint, thruster5_joint,
      thruster6_joint, thruster7_joint, thruster8_joint]
    tam:
      x: [-0.707, -0.707, 0.707, 0.707, 0.0, 0.0, 0.0, 0.0]
      y: [0.707, -0.707, 0.707, -0.707, 0.0, 0.0, 0.0, 0.0]
      z: [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
      rx: [0.0, 0.0, 0.0, 0.0, -0.21805, 0.21805, -0.21805, 0.21805]
      ry: [0.0, 0.0, 0.0, 0.0, -0.12, -0.12, 0.12, 0.12]
      rz: [0.1888, -0.1888, -0.1888, 0.1888, 0.0, 0.0, 0.0, 0.0]
""" + "".join(
    f"thruster{i}_controller: {{ros__parameters: {{thruster: thruster{i}_joint, min_thrust: -40.0,"
    f" max_thrust: {60.0 + (i == 3)}}}}}\n"
    for i in range(8, 0, -1)
)
"""Parameters of auv_controllers as Robotic-Decision-Making-Lab/blue has them, with one limit of our own."""


def test_a_tam_by_names_of_rows_has_its_thrusters_names_and_limits(tmp_path: Path) -> None:
    keys = imported(tmp_path, AUV_CONTROLLERS)
    vehicle, shipped = vehicle_of(keys, tmp_path), load_vehicle("bluerov2-heavy")
    np.testing.assert_array_equal(vehicle.T, shipped.T)
    assert vehicle.names == tuple(f"thruster{i}" for i in range(1, 9))
    assert vehicle.f_max.tolist() == [60, 60, 61, 60, 60, 60, 60, 60]
    assert vehicle.f_min.tolist() == [-40] * 8
    assert any("names no frame: frd" in note for note in keys.notes)


def test_a_vehicle_s_file_whose_comment_leaves_the_frame_undecided_is_refused(tmp_path: Path) -> None:
    """frd was taken where a comment said z up, or enu; and no comment of a tam was read at all."""
    table, limits = "surge,1,1\nsway,0.1,0.2\n", {"f_min": -20.0, "f_max": 20.0}
    for name, text in (("T.csv", table), ("tam.yaml", AUV_CONTROLLERS)):
        for comment, said in (("z up", "'# z up' may state a frame"), ("frame: enu", "states frame enu")):
            asked = f"# {comment}\n{text}"
            with pytest.raises(VehicleError, match=f"{said}.* give --frame frd or flu"):
                imported(tmp_path, asked, ImportOptions(**limits), name)
            assert imported(tmp_path, asked, ImportOptions(frame="flu", **limits), name).frame == "flu"
        told = imported(tmp_path, f"# frame: flu\n{text}", ImportOptions(**limits), name)
        assert told.frame == "flu"


def test_limits_of_a_tam_stay_with_thrusters_whose_names_are_left_out(tmp_path: Path) -> None:
    keys = imported(tmp_path, re.sub(r"\bthruster(?=\d)", "f", AUV_CONTROLLERS))
    vehicle = vehicle_of(keys, tmp_path)
    assert vehicle.names == ()
    assert vehicle.f_max.tolist() == vehicle_of(imported(tmp_path, AUV_CONTROLLERS), tmp_path).f_max.tolist()


@pytest.mark.parametrize("rows", [("rx:", "roll:"), ("rz:", "yaw:")])
def test_rows_of_a_tam_may_have_the_axes_names(tmp_path: Path, rows: tuple[str, str]) -> None:
    keys = imported(tmp_path, AUV_CONTROLLERS.replace(*rows))
    np.testing.assert_array_equal(vehicle_of(keys, tmp_path).T, load_vehicle("bluerov2-heavy").T)


@pytest.mark.parametrize(
    ("there", "put", "says"),
    [
        ("rx:", "phi:", "tam: got a row 'phi'"),
        ("rz: [0.1888, ", "rz: [", "rows of tam differ in length"),
        ("rx:", "surge:", "stand twice"),
        ("-40.0", "low", "min_thrust"),
    ],
)
def test_a_tam_by_names_that_is_none_is_refused(tmp_path: Path, there: str, put: str, says: str) -> None:
    with pytest.raises(AllocError, match=says):
        imported(tmp_path, AUV_CONTROLLERS.replace(there, put))


def test_an_impossible_column_is_refused_on_import_by_the_thruster_s_name(tmp_path: Path) -> None:
    spoiled = AUV_CONTROLLERS.replace("rx: [0.0", "rx: [0.11")
    with pytest.raises(AllocError, match=r"thruster1 \(surge -0\.707, sway 0\.707, roll 0\.11000"):
        imported(tmp_path, spoiled)


@pytest.mark.parametrize(
    ("header", "kept", "says"),
    [
        ("f1,f2,f3,f4", (), "f1 is thruster 0, f2 is thruster 1, f3 is thruster 2, f4 is thruster 3"),
        ("f0,stern,F3,u2", ("f0", "stern", "", ""), "F3 is thruster 2, u2 is thruster 3"),
        ("t1,t2,t3,t4", ("t1", "t2", "t3", "t4"), ""),
    ],
)
def test_names_that_are_other_thrusters_columns_are_left_out_with_a_remark(
    tmp_path: Path, header: str, kept: tuple[str, ...], says: str
) -> None:
    rows = "surge,1,1,0.7,0.7\nsway,0,0,0.7,-0.7\nyaw,0.2,-0.2,0.1,-0.1\n"
    keys = imported(tmp_path, f"dof,{header}\n{rows}", LIMITS, "T.csv")
    assert vehicle_of(keys, tmp_path).names == kept
    remark = f"Names that are other thrusters' numbers are left out: {says}."
    assert [note for note in keys.notes if "Names" in note] == ([remark] if says else [])


def test_a_header_of_a_csv_of_t_names_the_thrusters_and_is_as_long_as_a_row(tmp_path: Path) -> None:
    """Names were dropped, and a fifth thruster without a column was not missed."""
    file = tmp_path / "T.csv"
    rows = "surge,1,1,0.7,0.7\nsway,0,0,0.7,-0.7\nyaw,0.2,-0.2,0.1,-0.1\n"
    file.write_text(f"dof,bow,stern,port,stbd\n{rows}")
    assert csv.read(file).names == ["bow", "stern", "port", "stbd"]
    file.write_text(f"dof,f0,f1,f2,f3\n{rows}")
    assert csv.read(file).names is None
    file.write_text(f"dof,bow,stern,port,stbd,keel\n{rows}")
    with pytest.raises(VehicleError, match="rows differ in length"):
        csv.read(file)
    file.write_text(f"dof,bow,stern,port,stbd\n,N,N,N,N\n{rows}")
    with pytest.raises(FileError, match="line 2: says units"):
        csv.read(file)
