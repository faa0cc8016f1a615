"""Data in one frame meet a vehicle in another: what is turned, and the line that says so, in every way in."""

import csv
import io
import re
from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner, Result

from alloc import load_vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle.file import find_file, read_document
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF, unit
from alloc.vehicle.keys import to_yaml
from bench.__main__ import cli
from bench.demands import build_demands
from bench.inputs.columns import parse_columns
from bench.inputs.demand_csv import format_demands
from bench.inputs.frames import id_frame
from bench.inputs.logs import LogOptions, log_for, read_log
from bench.inputs.starter import first_demands
from tests.log_files import PLANAR, WRITERS, write_bag1, write_bag2, write_ulog
from tests.readers import written

BOX = """\
name: box
dof: [surge, sway, heave, roll, pitch, yaw]
frame: {frame}
thrusters:
  - {{position: [0.3, {s}0.2, 0], direction: [0.8, {t}0.6, 0]}}
  - {{position: [0.3, {t}0.2, 0], direction: [0.8, {s}0.6, 0]}}
  - {{position: [-0.3, {s}0.2, 0], direction: [0.8, {s}0.6, 0]}}
  - {{position: [-0.3, {t}0.2, 0], direction: [0.8, {t}0.6, 0]}}
  - {{position: [0.2, {s}0.3, {s}0.1], direction: [0, 0, {s}1]}}
  - {{position: [0.2, {t}0.3, {s}0.1], direction: [0, 0, {s}1]}}
  - {{position: [-0.2, {s}0.3, {s}0.1], direction: [0, 0, {s}1]}}
  - {{position: [-0.2, {t}0.3, {s}0.1], direction: [0, 0, {s}1]}}
center_of_mass: [0.01, 0, {s}0.02]
f_min: -31
f_max: 43
"""
TAU = np.array([[10.0, 3, 5, 0.5, 0.3, 2], [-20, 1, -8, 0, 0.4, -1], [0, 0, 20, 0, 0, 0]])
"""Demands in frd; the last one pushes down."""


@pytest.fixture
def box(tmp_path: Path) -> dict[str, Path]:
    """One vehicle, written in frd and in flu."""
    files = {}
    for frame, s, t in (("frd", "", "-"), ("flu", "-", "")):
        files[frame] = tmp_path / f"{frame}.yaml"
        files[frame].write_text(BOX.format(frame=frame, s=s, t=t))
    return files


def thrustbench(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, list(map(str, arguments)), catch_exceptions=False)


def thrusts(text: str) -> FloatArray:
    return np.array([[float(cell) for cell in row[1:]] for row in list(csv.reader(io.StringIO(text)))[1:]])


def allocated(vehicle: Path, log: Path) -> FloatArray:
    return thrusts(thrustbench("allocate", "--vehicle", vehicle, "--method", "nullspace", log).stdout)


def test_heave_of_a_vehicle_in_flu_is_up(box: dict[str, Path]) -> None:
    """Red before: a file in flu was turned on loading, its demands were not, and +heave pushed down."""
    flu = load_vehicle(box["flu"])
    assert flu.frame == "flu"
    f = np.where(np.arange(8) > 3, -5.0, 0.0)  # the vertical thrusters push down when positive
    assert (flu.T @ f)[2] == pytest.approx(20)


def test_a_demand_csv_is_in_the_vehicle_s_frame_and_the_same_thrusts_come_of_the_turned_one(
    box: dict[str, Path], tmp_path: Path
) -> None:
    plain = tmp_path / "ask.csv"
    answers = {}
    for frame, taus in (("frd", TAU), ("flu", turned(TAU.T, DOF).T)):
        plain.write_text("\n".join([",".join(DOF), *(",".join(map(str, tau)) for tau in taus.tolist())]))
        answers[frame] = allocated(box[frame], plain)
    np.testing.assert_allclose(answers["frd"], answers["flu"], rtol=0, atol=1e-9)
    assert answers["frd"][2, 4:].sum() == pytest.approx(20)


@pytest.mark.parametrize("frame", ["frd", "flu"])
@pytest.mark.parametrize("kind", ["ros1", "z down", "ulog", "csv with its frame"])
def test_a_log_gives_the_same_thrusts_on_either_vehicle(
    box: dict[str, Path], tmp_path: Path, kind: str, frame: str
) -> None:
    """Red before: the same demands as a bag and as a CSV gave opposite thrusts, and no line named a frame."""
    t = np.arange(3) / 50
    if kind == "csv with its frame":
        log = written(tmp_path / "log.csv", format_demands(t, turned(TAU.T, DOF).T, DOF, frame="flu"))
    else:
        log = WRITERS[kind](tmp_path, t, TAU)
    result = thrustbench("allocate", "--vehicle", box[frame], "--method", "nullspace", log)
    np.testing.assert_allclose(
        thrusts(result.stdout), allocated_in_frd(box, tmp_path), rtol=0, atol=1e-5
    )  # float32
    (line,) = [line for line in result.stderr.splitlines() if "frame" in line]
    down = kind in ("z down", "ulog")
    assert f"frame {'frd' if down else 'flu'} (" in line
    assert ("nothing turned" in line) == (frame == ("frd" if down else "flu"))
    assert ("turned into the vehicle's" in line) != ("nothing turned" in line)
    assert ("z down" if frame == "frd" else "z up") in line


def allocated_in_frd(box: dict[str, Path], tmp_path: Path) -> FloatArray:
    plain = written(tmp_path / "plain.csv", format_demands(None, TAU, DOF, frame="frd"))
    return allocated(box["frd"], plain)


def test_the_frame_of_a_log_stands_in_one_line_also_where_nothing_was_turned(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "surge,sway,yaw\n1,2,3\n")
    for told, frame, says in (
        ("", "frd", "frame frd (the file names none), the vehicle's own, nothing turned"),
        ("", "flu", "frame flu (the file names none), the vehicle's own, nothing turned"),
        ("flu", "frd", "frame flu (--frame), turned into the vehicle's frd: x ahead, y to starboard, z down"),
        ("frd", "flu", "frame frd (--frame), turned into the vehicle's flu: x ahead, y to port, z up"),
    ):
        log = read_log(file, PLANAR, LogOptions(frame=told), frame=frame)
        assert log.notes.startswith(f"log.csv: {says}")
        np.testing.assert_array_equal(log.taus, [[1, 2, 3]] if "nothing" in says else [[1, -2, -3]])


@pytest.mark.parametrize(
    "comment",
    [
        "# Frame: FLU",
        "% frame = flu",
        "// body frame: 'flu'",
        "#frame:flu, z up",
        "# frame_id: base_link_flu",
        "# header.frame_id = 'robot/base_link'",
    ],
)
def test_a_comment_says_the_frame_much_as_people_write_it(comment: str, tmp_path: Path) -> None:
    """The file with "# Frame: FLU" was said to name none, and sway and yaw had the wrong sign."""
    file = written(tmp_path / "log.csv", f"{comment}\n# frame rate: 50 Hz\nsurge,sway,yaw\n1,2,3\n")
    np.testing.assert_array_equal(read_log(file, PLANAR).taus, [[1, -2, -3]])


@pytest.mark.parametrize(
    ("comments", "named"),
    [
        ("# frame: enu\n", "enu"),
        ("# frame: frd\n# frame: flu\n", "flu and frd"),
        ("# frame_id: map\n", "map"),
        ("# frame_id: base_link\n# frame_id: base_link_ned\n", "flu and frd"),
    ],
)
def test_a_frame_that_is_none_or_two_is_refused_until_the_user_says_one(
    comments: str, named: str, tmp_path: Path
) -> None:
    file = written(tmp_path / "log.csv", f"{comments}surge,sway,yaw\n1,2,3\n")
    with pytest.raises(DemandError, match=rf"log\.csv: its comment states frame {named}, expected frd"):
        read_log(file, PLANAR)
    assert "frame flu (--frame)" in read_log(file, PLANAR, LogOptions(frame="flu")).notes


@pytest.mark.parametrize(
    "comment",
    [
        "# frame frd",
        "# axes: frd",
        "# NED",
        "% z down",
        "// heave positive down",
        "# wrench_frd",
        "#in flu",
        "# x forward, z-axis points up",
        "# body_frame: flu",
        "# forward, right, down",
        "# in the world frame",
        "# frame: x forward, y right",
        "# tau in base_link",
    ],
)
def test_a_comment_about_axes_in_another_form_is_refused_with_the_form_to_write(
    comment: str, tmp_path: Path
) -> None:
    """'the file names none' was said, nothing turned, and four signs were wrong in a vehicle in flu."""
    file = written(tmp_path / "log.csv", f"# dive 7\n{comment}\nsurge,sway,yaw\n1,2,3\n")
    says = "its comment states frame x" if "frame: x" in comment else f"line 2: {comment!r} may state a frame"
    with pytest.raises(DemandError, match=f"{re.escape(says)}.* give --frame frd or flu$") as refused:
        read_log(file, PLANAR)
    assert ("expected '# frame: frd' or '# frame: flu'; write that" in str(refused.value)) == ("may" in says)
    assert read_log(file, PLANAR, LogOptions(frame="flu")).taus.tolist() == [[1, -2, -3]]
    file.write_text(f"{comment}\n# frame: flu\nsurge,sway,yaw\n1,2,3\n")
    if "frame:" not in comment:
        assert read_log(file, PLANAR).taus.tolist() == [[1, -2, -3]]


@pytest.mark.parametrize(
    "comment", ["# leak on the port bow", "# z up to 3 m", "# frame rate 50 Hz", "# fluid"]
)
def test_a_comment_about_other_things_says_no_frame(comment: str, tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", f"{comment}\nsurge,sway,yaw\n1,2,3\n")
    assert "the file names none" in read_log(file, PLANAR).notes


def test_names_of_columns_that_are_about_axes_are_refused_until_a_frame_is_said(tmp_path: Path) -> None:
    """The file with 'flu/fx' was said to name no frame."""
    file = tmp_path / "log.csv"
    columns = {"surge": "flu/fx [N]", "sway": "flu/fy [N]", "yaw": "flu/mz [Nm]"}
    file.write_text("flu/fx,flu/fy,flu/mz\n1,2,3\n")
    with pytest.raises(DemandError, match=r"column 'flu/fx' may state a frame.* or give --frame frd or flu"):
        read_log(file, PLANAR, LogOptions(columns=columns))
    told = read_log(file, PLANAR, LogOptions(columns=columns, frame="flu"))
    assert told.taus.tolist() == [[1, -2, -3]]
    file.write_text("# frame: flu\nflu/fx,flu/fy,flu/mz\n1,2,3\n")
    assert read_log(file, PLANAR, LogOptions(columns=columns)).taus.tolist() == [[1, -2, -3]]


@pytest.mark.parametrize("told", ["", "flu"])
def test_a_comment_and_a_column_about_other_axes_are_refused_until_a_frame_is_said(
    told: str, tmp_path: Path
) -> None:
    """The comment was taken, and of the column that contradicts it nothing was said."""
    for comment, name, cell in (("frd", "frame", "flu"), ("flu", "frame_id", "base_link_ned")):
        file = written(tmp_path / "log.csv", f"# frame: {comment}\n{name},surge,sway,yaw\n{cell},1,2,3\n")
        if told:
            assert read_log(file, PLANAR, LogOptions(frame=told)).taus.tolist() == [[1, -2, -3]]
            continue
        with pytest.raises(DemandError, match=f"states frame {comment}, a row of it '{cell}', expected"):
            read_log(file, PLANAR)
    file.write_text("# frame: frd\nframe_id,surge,sway,yaw\nrov,1,2,3\n")  # no word about axes
    assert read_log(file, PLANAR).stated.frame == "frd"


@pytest.mark.parametrize("asked", ["", "frd", "flu"])
@pytest.mark.parametrize("own", ["frd", "flu"])
def test_what_allocate_says_was_made_is_in_the_frame_that_was_asked_for_and_named(
    own: str, asked: str, tmp_path: Path
) -> None:
    """made_* stood in the vehicle's frame, and nothing in the file said which that was."""
    heavy = load_vehicle("bluerov2-heavy")
    keys = read_document(find_file("bluerov2-heavy")).keys
    file, log, out = (tmp_path / name for name in ("own.yaml", "log.csv", "out.csv"))
    T = heavy.with_frame(own).T.tolist()
    file.write_text(to_yaml(msgspec.structs.replace(keys, thrusters=None, T=T, frame=own)))
    log.write_text(format_demands(None, TAU / 2, DOF, frame=asked or own))
    command = ("allocate", log, "--vehicle", file, "--method", "nullspace", "--esc", "-o", out)
    assert thrustbench(*command, *(["--frame", asked] if asked else [])).exit_code == 0
    made = {axis: f"made_{axis} [{unit(axis)}]" for axis in DOF}
    back = read_log(out, DOF, LogOptions(columns=made), frame=asked or own)
    np.testing.assert_allclose(back.taus, TAU / 2, atol=0.5)  # a step of the ESCs is 0.1 N
    assert (back.stated.frame, "nothing turned" in back.notes) == (asked or own, True)


def test_bags_and_ulogs_say_why_their_frame_is_taken(tmp_path: Path) -> None:
    t = np.arange(3) / 50
    for folder in "abcd":
        (tmp_path / folder).mkdir()
    said = [
        read_log(write_bag1(tmp_path / "a", t, TAU), DOF).notes,
        read_log(write_bag2(tmp_path / "b", t, TAU, frame="base_link_ned"), DOF).notes,
        read_log(write_ulog(tmp_path / "c", t, TAU), DOF).notes,
        read_log(write_bag2(tmp_path / "d", t, TAU, frame="base_link"), DOF).notes,
    ]
    for line, why in zip(
        said,
        (
            "as ROS has it",
            "its frame_id is 'base_link_ned'",
            "as PX4 has it",
            "as ROS has it, frame_id 'base_link'",
        ),
        strict=True,
    ):
        assert f"({why})" in line


@pytest.mark.parametrize(
    ("header", "frame", "columns", "refused"),
    [
        ("wrench/force/x,wrench/force/y,wrench/torque/z", "frd", "", True),
        ("force.x,force.y,torque.z", "frd", "", True),
        ("force x,force y,torque z", "frd", "", True),
        ("Force.X,Force.Y,Torque.Z", "frd", "", True),
        ("force.x,force.y,torque.z", "flu", "", False),
        ("/a/force/x,/a/force/y,/a/torque/z", "frd", "surge={} [N],sway={} [N],yaw={} [Nm]", True),
        ("surge,sway,yaw", "frd", "", False),
        ("Fx,Fy,Mz", "frd", "", False),
    ],
)
def test_columns_named_as_in_ros_need_a_frame_on_a_vehicle_with_z_down(
    tmp_path: Path, header: str, frame: str, columns: str, refused: bool
) -> None:
    """They were taken as they stand, with a warning."""
    file = written(tmp_path / "log.csv", f"{header}\n1,2,3\n")
    given = parse_columns(columns.format(*header.split(",")))
    if refused:
        with pytest.raises(DemandError, match=r"is named as in ROS, where z is up, .* give --frame flu"):
            read_log(file, PLANAR, LogOptions(columns=given), frame=frame)
    else:
        assert "nothing turned" in read_log(file, PLANAR, LogOptions(columns=given), frame=frame).notes
    for told in ("frd", "flu"):
        log = read_log(file, PLANAR, LogOptions(frame=told, columns=given), frame=frame)
        assert log.taus.tolist() == [[1, 2, 3] if told == frame else [1, -2, -3]]


def test_what_demands_writes_names_its_frame_and_is_read_back_into_either(
    box: dict[str, Path], tmp_path: Path
) -> None:
    bag, out = write_bag1(tmp_path, np.arange(3) / 50, TAU), tmp_path / "out.csv"
    for frame in ("frd", "flu"):
        thrustbench("demands", bag, "--vehicle", box[frame], "-o", out)
        assert out.read_text().startswith(f"# frame: {frame} (x ahead, ")
        np.testing.assert_array_equal(read_log(out, DOF, frame="frd").taus, TAU)


@pytest.mark.parametrize("frame", ["frd", "flu"])
def test_the_demands_to_start_from_name_their_frame(frame: str, box: dict[str, Path], tmp_path: Path) -> None:
    file, vehicle = tmp_path / "demands.csv", load_vehicle(box[frame])
    file.write_text(first_demands(vehicle))
    log = log_for(vehicle, file, LogOptions())
    assert (log.stated.frame, "nothing turned" in log.notes) == (frame, True)


@pytest.mark.parametrize("form", ["csv", "ros"])
def test_a_vehicle_exported_and_imported_keeps_its_frame(
    box: dict[str, Path], tmp_path: Path, form: str
) -> None:
    answers = []
    for frame in ("frd", "flu"):
        there, back = tmp_path / f"there.{'csv' if form == 'csv' else 'yaml'}", tmp_path / "back.yaml"
        thrustbench("export", box[frame], "--format", form, "-o", there)
        assert f"# frame: {frame}" in there.read_text()
        thrustbench("import", there, "--f-min", "-31", "--f-max", "43", "-o", back)
        assert load_vehicle(back).frame == frame
        log = written(tmp_path / "ask.csv", format_demands(None, TAU, DOF, frame="frd"))
        answers.append(allocated(back, log))
    np.testing.assert_allclose(answers[0], answers[1], rtol=0, atol=1e-9)


def test_demands_of_a_run_are_labelled_alike_in_either_frame(box: dict[str, Path], tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", format_demands(None, np.vstack([TAU, 20 * TAU]), DOF, frame="frd"))
    made = [build_demands(log, load_vehicle(box[frame]), 0) for frame in ("frd", "flu")]
    np.testing.assert_array_equal(made[0].labels, made[1].labels)
    assert len(set(made[0].labels.tolist())) > 1
    np.testing.assert_allclose(made[0].alpha, made[1].alpha, rtol=1e-9)
    np.testing.assert_array_equal(turned(made[0].taus.T, DOF).T, made[1].taus)


@pytest.mark.parametrize("name", ["mission", "mission-fault"])
def test_a_mission_is_the_same_flight_in_either_frame(box: dict[str, Path], name: str) -> None:
    """Weight pulls down in both, and a vehicle whose limits differ ahead and astern reaches as far."""
    made = [build_demands(name, load_vehicle(box[frame]), 1, 300) for frame in ("frd", "flu")]
    scale = made[0].vehicle.wrench_scale
    # The simulation feeds rounding back, so that the last digits differ after some hundred steps.
    np.testing.assert_allclose(turned(made[0].taus.T, DOF).T / scale, made[1].taus / scale, atol=1e-6)
    assert np.ptp(made[0].taus[:, 2]) > 0


ECHO = "time,field.header.stamp,field.header.frame_id," + ",".join(
    f"field.wrench.{part}.{axis}" for part in ("force", "torque") for axis in "xyz"
)
"""The header that rostopic writes of a WrenchStamped, behind a %."""


def echoed(path: Path, *ids: str, mark: str = "%", comment: str = "") -> Path:
    """A CSV of wrenches under these frame_ids, as rostopic writes it."""
    rows = [f"{i * 10**7},0,{name},{','.join(map(str, TAU[i]))}" for i, name in enumerate(ids)]
    path.write_text("\n".join([*filter(None, [comment]), mark + ECHO, *rows]) + "\n")
    return path


@pytest.mark.parametrize("mark", ["%", ""])
@pytest.mark.parametrize(("name", "frame"), [("base_link_ned", "frd"), ("base_link", "flu")])
@pytest.mark.parametrize("vehicle", ["frd", "flu"])
def test_a_column_with_frame_ids_says_the_frame(
    vehicle: str, name: str, frame: str, mark: str, tmp_path: Path
) -> None:
    """As it does in a bag: sway and yaw had the wrong sign, and 'the file names none' was said."""
    log = read_log(echoed(tmp_path / "log.csv", name, name, mark=mark), DOF, frame=vehicle)
    expected = TAU[:2] if frame == vehicle else turned(TAU[:2].T, DOF).T
    np.testing.assert_array_equal(log.taus, expected)
    assert "names none" not in log.notes
    assert "frame_id, " not in log.notes
    assert log.doubt == ""


def test_frame_ids_that_do_not_turn_or_contradict_each_other_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    with pytest.raises(DemandError, match="its frame_id 'map' does not turn with the vehicle, expected"):
        read_log(echoed(file, "map", "map"), DOF, frame="flu")
    assert "--frame" in read_log(file, DOF, LogOptions(frame="flu"), frame="flu").notes
    with pytest.raises(DemandError, match="states frame 'base_link_ned' and 'base_link', expected"):
        read_log(echoed(file, "base_link", "base_link_ned"), DOF)
    told = read_log(echoed(file, "base_link_ned", comment="# frame: frd"), DOF, frame="flu")
    assert "its comment" in told.notes


@pytest.mark.parametrize(
    ("name", "frame"),
    [
        ("base_link", "flu"),
        ("base_link_fsd", "frd"),
        ("rov/base_link_frd", "frd"),
        ("ned/base_link", "frd"),
        ("BaseLinkNED", "frd"),
        ("gravity_aligned", "flu"),
        ("fsdrov", "flu"),
    ],
)
def test_a_frame_id_says_by_a_word_that_z_is_down(name: str, frame: str) -> None:
    """fsd is ahead, starboard, down: taken for z up, sway, heave, pitch and yaw changed their signs."""
    assert id_frame(name) == frame


@pytest.mark.parametrize(
    ("name", "cell", "yaw", "said"),
    [
        ("frame", "flu", -3, "frame flu (as ROS has it, frame_id 'flu'), turned"),
        ("frame", "body_flu", -3, "frame flu (as ROS has it, frame_id 'body_flu'), turned"),
        ("frame", "Z down", 3, "frame frd (its frame_id is 'z down')"),
        ("frame", "", 3, "frame frd (the file names none)"),
        ("frame_id", "rov", -3, "frame flu (as ROS has it, frame_id 'rov'), turned"),
        ("mode", "AUTO", 3, "left out: mode"),
        ("frame", "1042", None, "its column 'frame' states frame '1042', expected frd or flu"),  # of a camera
        ("frame", "body", None, "its column 'frame' states frame 'body', expected frd or flu"),
        ("frame", "enu", None, "its frame_id 'enu' does not turn with the vehicle"),
        ("coordinate_frame", "FRD", None, "column 'coordinate_frame' with 'frd' may state a frame"),
        ("axes", "flu", None, "column 'axes' with 'flu' may state a frame"),
        ("imu.header.frame_id", "imu_ned", None, "column 'imu.header.frame_id' with 'imu_ned' may state"),
    ],
)
def test_a_column_that_states_a_frame_is_read_or_refused(
    name: str, cell: str, yaw: float | None, said: str, tmp_path: Path
) -> None:
    """It said flu, and the program that the file names no frame; sway and yaw had the other sign."""
    file = written(tmp_path / "log.csv", f"{name},surge,sway,yaw\n{cell},1,2,3\n")
    if yaw is None:
        with pytest.raises(DemandError, match=re.escape(said)):
            log_for(load_vehicle("ukwial"), file)
        assert log_for(load_vehicle("ukwial"), file, LogOptions(frame="flu")).taus[0, 2] == -3
        return
    log = log_for(load_vehicle("ukwial"), file)
    assert (log.taus[0, 2], said in log.notes) == (yaw, True)
