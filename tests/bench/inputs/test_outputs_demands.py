"""Demands beside the commands to ESCs: their frame, their columns, and what is doubted of them."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, load_vehicle
from alloc.vehicle.frame import turned
from bench.__main__ import cli
from bench.inputs.demand_csv import csv_text
from bench.inputs.logs import read_log
from bench.inputs.outputs import read_outputs
from tests.output_logs import write_bin, write_outputs_ulog
from tests.readers import written

VEHICLE = load_vehicle("bluerov2-heavy")
T = np.arange(5) * 0.02
REST = np.full((5, 8), 1500.0)
SHARES = np.linspace(-0.5, 0.5, 30).reshape(5, 6)


def binary(path: Path) -> Path:
    pytest.importorskip("pymavlink", reason="the extra ardupilot")
    return write_bin(path, T, REST.astype(int), np.full(5, 16.0), SHARES[:, 3:])


def ulog(path: Path) -> Path:
    return write_outputs_ulog(path, T, REST, np.full(5, 16.0), SHARES)


def with_demands(folder: Path, axes: str, comment: str = "") -> Path:
    """A log of one row at rest that has demands in these columns."""
    file = folder / "both.csv"
    cells = ["1500"] * 8 + ["2"] * len(axes.split(","))
    file.write_text(f"{comment}u0,u1,u2,u3,u4,u5,u6,u7,{axes}\n{','.join(cells)}\n")
    return file


def test_demands_named_as_in_ros_are_refused_until_a_frame_is_given(tmp_path: Path) -> None:
    """The undone part had the wrong sign along y and z, and --frame was refused."""
    ros = "force.x,force.y,force.z,torque.x,torque.y,torque.z"
    file = with_demands(tmp_path, ros)
    with pytest.raises(AllocError, match=r"'force.y' is named as in ROS, where z is up"):
        read_outputs(file, VEHICLE)
    for frame, taus in (("flu", [2, -2, -2, 2, -2, -2]), ("frd", [2] * 6)):
        told = read_outputs(file, VEHICLE, frame=frame)
        assert told.taus is not None
        assert (told.taus.tolist(), told.doubt) == ([taus], "")
        assert f"frame {frame} (--frame)" in told.notes
    assert "its comment" in read_outputs(with_demands(tmp_path, ros, "# frame: flu\n"), VEHICLE).notes
    command = ["demands", str(with_demands(tmp_path, ros)), "--vehicle", VEHICLE.name, "--from-outputs"]
    told_so = CliRunner().invoke(cli, [*command, "--frame", "flu"], standalone_mode=False)
    assert "frame flu (--frame)" in told_so.stderr


@pytest.mark.parametrize("none", ["", "NaN", " nan "])
def test_rows_of_logs_that_were_merged_have_commands_a_demand_or_both(none: str, tmp_path: Path) -> None:
    """NaN was refused with the remedy to write a number, and a 0 there is a demand that nobody made."""
    file = tmp_path / "merged.csv"
    commands, nothing = ",".join(["1600"] * 8), ",".join([none] * 8)
    rows = [f"0,{commands},1,2", f"1,{commands},{none},{none}", f"2,{nothing},3,4", f"3,{commands},5,6"]
    file.write_text("\n".join(["t,u0,u1,u2,u3,u4,u5,u6,u7,surge,yaw", *rows]))
    outputs = read_outputs(file, VEHICLE)
    assert outputs.t is not None
    assert outputs.taus is not None
    assert outputs.t.tolist() == [0, 1, 3]
    assert outputs.u.tolist() == [[1600] * 8] * 3
    np.testing.assert_array_equal(outputs.taus[:, 0], [1, np.nan, 5])
    assert "; 1 rows without commands, 1 of them with demands, which are not compared" in outputs.notes
    file.write_text(file.read_text().replace("2,", f"2,1600{none},", 1))
    with pytest.raises(AllocError, match=r"merged\.csv, line"):
        read_outputs(file, VEHICLE)


def test_commands_and_demands_that_share_no_row_are_said_to(tmp_path: Path) -> None:
    """A log with demands in every other row was said to have none."""
    file = tmp_path / "joined.csv"
    rows = ["0,,,,,,,,,10,5", "1,1600,1600,1600,1600,1600,1600,1600,1600,,", "2,,,,,,,,,11,5"]
    file.write_text("\n".join(["t,u0,u1,u2,u3,u4,u5,u6,u7,surge,yaw", *rows]))
    said = CliRunner().invoke(cli, ["demands", str(file), "--vehicle", VEHICLE.name, "--from-outputs"])
    assert re.search(r"left undone +not known: no row has commands and a demand", said.stdout)
    assert "2 rows without commands, 2 of them with demands, which are not compared: fill" in said.stderr


def test_a_row_without_the_battery_s_voltage_says_how_to_fill_it_in(tmp_path: Path) -> None:
    file = tmp_path / "merged.csv"
    for none in ("", "NaN"):
        file.write_text(f"surge,sway,heave,roll,pitch,yaw,volts\n1,2,3,0,0,1,16\n1,2,3,0,0,1,{none}\n")
        with pytest.raises(AllocError, match=r"line 3: volts is .*; use the previous row's"):
            read_log(file, VEHICLE.dof)


def test_a_frame_of_a_log_without_demands_and_one_that_is_none_are_refused(tmp_path: Path) -> None:
    file = written(tmp_path / "u.csv", "u0,u1,u2,u3,u4,u5,u6,u7\n" + "1500," * 7 + "1500\n")
    with pytest.raises(AllocError, match="has no demands that could be in a frame; leave out --frame flu"):
        read_outputs(file, VEHICLE, frame="flu")
    with pytest.raises(AllocError, match="its comment states frame enu, expected frd or flu"):
        read_outputs(with_demands(tmp_path, "surge", "# frame: enu\n"), VEHICLE)
    with pytest.raises(AllocError, match="line 1: '# NED' may state a frame, expected"):
        read_outputs(with_demands(tmp_path, "surge", "# NED\n"), VEHICLE)


def test_columns_of_demands_that_could_be_meant_twice_are_named_by_the_user(tmp_path: Path) -> None:
    """Both were left out with a word, and nothing was said to be undone."""
    told = read_outputs(with_demands(tmp_path, "surge,fx [kN]"), VEHICLE, {"surge": "fx [kN]"})
    assert told.taus is not None
    assert told.taus[0, 0] == 2000
    with pytest.raises(AllocError, match="has no columns; --columns is for tables, leave it out"):
        read_outputs(ulog(tmp_path), VEHICLE, {"surge": "fx"})


@pytest.mark.parametrize("write", [binary, ulog])
def test_demands_of_an_autopilot_are_turned_into_the_vehicle_s_frame_with_a_word(
    tmp_path: Path, write: Callable[[Path], Path]
) -> None:
    file = write(tmp_path)
    frd, flu = read_outputs(file, VEHICLE), read_outputs(file, VEHICLE.with_frame("flu"))
    assert frd.taus is not None
    assert flu.taus is not None
    np.testing.assert_array_equal(turned(frd.taus.T, VEHICLE.dof).T, flu.taus)
    assert "turned into the vehicle's flu" in flu.notes


def test_a_scale_counts_beside_commands_and_is_refused_without_demands(tmp_path: Path) -> None:
    command = ("demands", "--vehicle", VEHICLE.name, "--from-outputs")
    undone = []
    for factor in (1.0, 40.0):
        header = [*VEHICLE.dof, *(f"u{i}" for i in range(8))]
        rows = np.column_stack([0.2 * 40 / factor * SHARES, REST]).tolist()
        file = written(tmp_path / f"{factor:g}.csv", csv_text(header, rows))
        done = CliRunner().invoke(cli, [*command, str(file), "--scale", f"{factor:g}"], standalone_mode=False)
        undone.append(done.stdout.partition("undone")[2].splitlines()[0])
    assert undone[0] == undone[1]
    bare = written(tmp_path / "u.csv", csv_text([f"u{i}" for i in range(8)], REST.tolist()))
    done = CliRunner().invoke(cli, [*command, str(bare), "--scale", "2"], standalone_mode=False)
    assert "has no demands that could be scaled; leave out --scale" in str(done.exception)
