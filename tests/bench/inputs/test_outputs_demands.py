"""Demands beside the commands to ESCs: their frame, their columns, and what is doubted of them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, load_vehicle
from alloc.vehicle.frame import turned
from bench.__main__ import cli
from bench.inputs.logs import read_log
from bench.inputs.outputs import read_outputs
from tests.output_logs import write_bin, write_outputs_ulog

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


def test_demands_named_as_in_ros_are_doubted_as_in_a_log_of_demands_until_a_frame_is_said(
    tmp_path: Path,
) -> None:
    """What was undone had the wrong sign along y and z, and --frame was refused."""
    ros = "force.x,force.y,force.z,torque.x,torque.y,torque.z"
    file = with_demands(tmp_path, ros)
    assert read_outputs(file, VEHICLE).doubt == read_log(file, VEHICLE.dof).doubt != ""
    for frame, taus in (("flu", [2, -2, -2, 2, -2, -2]), ("frd", [2] * 6)):
        told = read_outputs(file, VEHICLE, frame=frame)
        assert told.taus is not None
        assert (told.taus.tolist(), told.doubt) == ([taus], "")
        assert f"frame {frame} (--frame)" in told.said
    assert read_outputs(with_demands(tmp_path, ros, "# frame: flu\n"), VEHICLE).doubt == ""
    assert read_outputs(with_demands(tmp_path, ",".join(VEHICLE.dof)), VEHICLE).doubt == ""
    command = ["demands", str(with_demands(tmp_path, ros)), "--vehicle", VEHICLE.name, "--from-outputs"]
    assert "is named as in ROS" in CliRunner().invoke(cli, command, standalone_mode=False).stderr
    told_so = CliRunner().invoke(cli, [*command, "--frame", "flu"], standalone_mode=False)
    assert "named as in ROS" not in told_so.stderr
    assert "frame flu (--frame)" in told_so.stderr


def test_a_frame_of_a_log_without_demands_and_one_that_is_none_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "u.csv"
    file.write_text("u0,u1,u2,u3,u4,u5,u6,u7\n" + "1500," * 7 + "1500\n")
    with pytest.raises(AllocError, match="has no demands that could be in a frame; leave out --frame flu"):
        read_outputs(file, VEHICLE, frame="flu")
    with pytest.raises(AllocError, match="its comment says frame enu; give --frame frd or flu"):
        read_outputs(with_demands(tmp_path, "surge", "# frame: enu\n"), VEHICLE)


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
    assert "turned into the vehicle's flu" in flu.said
