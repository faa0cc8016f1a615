"""Vehicles exported to files of other projects, and vehicle files written anew, read back the same."""

import re
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, list_vehicles, load_vehicle
from alloc.lint.autopilot import choose
from alloc.vehicle.file import build_vehicle, find_file, read_document, suspects
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import AutopilotKeys, Thruster, VehicleFile, to_yaml
from bench.__main__ import cli
from bench.inputs.formats import formats, lost_keys
from tests.foreign_vehicles import LIMITS, imported, vehicle_of

SOUND = [name for name in list_vehicles() if not read_document(find_file(name)).keys.suspect]
"""Vehicles without a column of T that no thruster can make, which an import refuses unasked."""


@pytest.mark.parametrize("name", SOUND)
def test_a_vehicle_exported_to_ros_comes_back_the_same(tmp_path: Path, name: str) -> None:
    keys = read_document(find_file(name)).keys
    vehicle = build_vehicle(keys)
    back = vehicle_of(imported(tmp_path, formats()["ros"].write(keys, vehicle)), tmp_path)
    assert back.dof == vehicle.dof
    for key in ("T", "H", "f_min", "f_max", "slack_weights"):
        np.testing.assert_allclose(getattr(back, key), getattr(vehicle, key), rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize("form", ["csv", "ros"])
@pytest.mark.parametrize("name", ["ukwial", "nautilus"], ids=["by T", "by poses"])
def test_axes_in_another_order_come_back_as_the_same_axes(tmp_path: Path, name: str, form: str) -> None:
    """Rows went out in the order of ``dof`` and came back as surge, sway, yaw: yaw's moments pushed ahead."""
    keys = read_document(find_file(name)).keys
    keys.dof = keys.dof[::-1]
    keys.slack_weights = [2000.0 + i for i in range(len(keys.dof))]
    vehicle = build_vehicle(keys)
    file = "T.csv" if form == "csv" else "theirs.yaml"
    back = vehicle_of(imported(tmp_path, formats()[form].write(keys, vehicle), LIMITS, file), tmp_path)
    there = [back.dof.index(axis) for axis in vehicle.dof]
    np.testing.assert_allclose(back.T[there], vehicle.T, rtol=0, atol=1e-16)
    if form == "ros":
        np.testing.assert_array_equal(back.slack_weights[there], vehicle.slack_weights)


@pytest.mark.parametrize("name", SOUND)
def test_a_vehicle_exported_to_csv_comes_back_with_the_same_matrix(tmp_path: Path, name: str) -> None:
    keys = read_document(find_file(name)).keys
    vehicle = build_vehicle(keys)
    back = imported(tmp_path, formats()["csv"].write(keys, vehicle), LIMITS, "T.csv")
    assert tuple(back.dof) == vehicle.dof
    np.testing.assert_array_equal(np.array(back.T), vehicle.T)


@pytest.mark.parametrize("form", ["csv", "ros"])
def test_columns_that_no_thruster_can_make_come_back_where_the_user_takes_them_as_published(
    tmp_path: Path, form: str
) -> None:
    """Import refused the export of a shipped vehicle, and named no way."""
    keys = read_document(find_file("tiburon")).keys
    vehicle, file = build_vehicle(keys), tmp_path / ("T.csv" if form == "csv" else "theirs.yaml")
    file.write_text(formats()[form].write(keys, vehicle), encoding="utf-8")
    ask = ["import", str(file), "--f-min", "-1", "--f-max", "1", "-o", str(tmp_path / "ours.yaml")]
    refused = CliRunner().invoke(cli, ask, standalone_mode=False).exception
    way = str(refused).rpartition("to take all such as published: ")[2].split()
    assert way == ["--suspect", ",".join(map(str, sorted(suspects(keys, vehicle.n))))]
    assert CliRunner().invoke(cli, [*ask, *way], standalone_mode=False).exception is None
    np.testing.assert_array_equal(load_vehicle(tmp_path / "ours.yaml").T, vehicle.T)
    unknown = CliRunner().invoke(cli, [*ask, "--suspect", "T9"], standalone_mode=False).exception
    assert isinstance(unknown, AllocError)
    assert str(file) in str(unknown)


@pytest.mark.parametrize("name", list_vehicles())
def test_a_vehicle_file_written_anew_reads_the_same(tmp_path: Path, name: str) -> None:
    keys = read_document(find_file(name)).keys
    path = tmp_path / "again.yaml"
    path.write_text(to_yaml(keys), encoding="utf-8")
    assert read_document(path).keys == keys


@pytest.mark.parametrize(
    "text", ["yes", "a: b", "#1", "", "1e5", "tab\there", "ü ü", "[x]", "- x", "'q'", "a\nb"]
)
def test_any_text_in_a_vehicle_file_reads_the_same_once_written(tmp_path: Path, text: str) -> None:
    keys = read_document(find_file("ukwial")).keys
    keys.source, keys.notes = text, [text]
    path = tmp_path / "again.yaml"
    path.write_text(to_yaml(keys), encoding="utf-8")
    assert read_document(path).keys == keys


def test_an_export_says_what_the_format_has_no_place_for(tmp_path: Path) -> None:
    """The file that is read back lacks just these keys, and notes of an import's assumptions."""
    keys = read_document(find_file("bluerov2-heavy")).keys
    keys.names = list("abcdefgh")
    lost = ["slew", "volts", "esc", "inertia", "priority", "names", "autopilot"]
    assert lost_keys("ros", keys) == lost
    assert set(lost_keys("csv", keys)) == {*lost_keys("ros", keys), "f_min", "f_max"}
    back = imported(tmp_path, formats()["ros"].write(keys, build_vehicle(keys)))
    assert not set(lost) & msgspec.to_builtins(back).keys()


def test_a_vehicle_with_a_full_h_can_not_be_exported_to_ros() -> None:
    keys = read_document(find_file("ukwial")).keys
    keys.H = (np.eye(4) + 0.1).tolist()
    with pytest.raises(AllocError, match="H is not diagonal"):
        formats()["ros"].write(keys, build_vehicle(keys))


@pytest.mark.parametrize("name", SOUND)
def test_a_vehicle_exported_to_px4_comes_back_with_the_same_geometry(tmp_path: Path, name: str) -> None:
    keys = read_document(find_file(name)).keys
    vehicle = build_vehicle(keys)
    text = formats()["px4"].write(keys, vehicle)
    back = vehicle_of(imported(tmp_path, text, name="theirs.params"), tmp_path)
    theirs, known = back.with_frame(vehicle.frame), [a for a in vehicle.dof if a in back.dof]
    assert set(known) == set(vehicle.dof)
    ours = vehicle.T if vehicle.poses is None else vehicle.poses[[DOF.index(a) for a in known]]
    # A published T has three digits where the poses beside it have more.
    np.testing.assert_allclose(theirs.T[[theirs.dof.index(a) for a in known]], ours, rtol=0, atol=1e-3)
    unit = float(re.findall(r"CT 1: (\S+) N", text)[0])
    np.testing.assert_allclose(unit * back.f_max, vehicle.f_max, rtol=1e-5)
    assert back.f_max.max() <= 100 * (1 + 1e-9)
    np.testing.assert_array_equal(back.f_min < 0, vehicle.f_min < 0)
    assert ("f_min differs" in text) == (not np.allclose(vehicle.f_min, -vehicle.f_max))


@pytest.mark.parametrize(
    "said", [AutopilotKeys(px4="automatic", airmode=2), AutopilotKeys(px4="pseudoinverse")], ids=str
)
def test_how_px4_shall_allocate_comes_back_from_the_parameters(said: AutopilotKeys, tmp_path: Path) -> None:
    keys = read_document(find_file("bluerov2-heavy")).keys
    keys.autopilot = said
    file = tmp_path / "rov.params"
    file.write_text(formats()["px4"].write(keys, build_vehicle(keys)))
    back = choose(str(file), None)
    assert (back.px4, back.airmode, len(back.motors)) == (said.px4, said.airmode, 8)


def test_px4_gets_positions_from_the_centre_of_mass_and_axes_in_frd(tmp_path: Path) -> None:
    keys = read_document(find_file("subjugator8")).keys
    keys.center_of_mass, keys.reaction_torque = (0.02, 0.03, -0.04), 0.01
    vehicle = build_vehicle(keys)
    text = formats()["px4"].write(keys, vehicle)
    back = vehicle_of(imported(tmp_path, text, name="theirs.params"), tmp_path).with_frame(vehicle.frame)
    np.testing.assert_allclose(back.T, vehicle.T, rtol=0, atol=1e-4)  # published axes have four digits


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            lambda keys: setattr(
                keys, "thrusters", [Thruster(t.position, t.direction) for t in keys.thrusters] * 2
            ),
            "16 thrusters; PX4 has parameters for 12",
        ),
        (lambda keys: setattr(keys, "f_max", 0.0), "f_max of FLH is 0, expected above 0; turn its direction"),
    ],
)
def test_what_px4_has_no_parameters_for_is_refused(change: Callable[[VehicleFile], None], says: str) -> None:
    keys = read_document(find_file("subjugator8")).keys
    keys.T, keys.names, keys.slew = None, None, None
    change(keys)
    with pytest.raises(AllocError, match=says):
        formats()["px4"].write(keys, build_vehicle(keys))


def test_a_column_without_a_pose_is_refused_by_px4() -> None:
    keys = read_document(find_file("tiburon")).keys
    with pytest.raises(AllocError, match="T gives T6 no pose, which PX4's parameters need"):
        formats()["px4"].write(keys, build_vehicle(keys))


@pytest.mark.parametrize("name", SOUND)
def test_factors_of_ardusub_s_custom_frame_make_one_axis_and_no_other(name: str) -> None:
    """Read back from the text: roll, pitch, yaw, throttle, forward, lateral of motors 1, 2, …."""
    keys = read_document(find_file(name)).keys
    vehicle = build_vehicle(keys)
    text = formats()["ardusub-matrix"].write(keys, vehicle)
    assert "FRAME_CONFIG = 7" in text
    table = re.findall(r"add_motor_raw_6dof\(AP_MOTORS_MOT_(\d+), (.*), (\d+)\);", text)
    assert [int(motor) for motor, _, _ in table] == list(range(1, vehicle.n + 1))
    rows = np.array([[float(word.strip("f")) for word in row.split(", ")] for _, row, _ in table])
    columns = ("roll", "pitch", "yaw", "heave", "surge", "sway")
    mixer, senses = (
        vehicle.autopilot,
        np.array([1, 1, -1, 1, 1, 1] if vehicle.frame == "frd" else [1, -1, 1, 1, -1, -1]),
    )
    order = range(vehicle.n) if mixer is None else np.array(mixer.motors) - 1
    signs = np.ones(vehicle.n) if mixer is None else np.array(mixer.directions)
    outputs = rows[order] * signs[:, None]
    made = vehicle.T @ (outputs * ((vehicle.f_max - vehicle.f_min) / 2)[:, None])
    for i, axis in enumerate(vehicle.dof):
        column = made[:, columns.index(axis)] / vehicle.wrench_scale
        assert column[i] * senses[DOF.index(axis)] > 0.1
        np.testing.assert_allclose(np.delete(column, i), 0.0, atol=1e-5)
        assert np.abs(rows[:, columns.index(axis)]).max() == 1.0
    left = [j for j, axis in enumerate(columns) if axis not in vehicle.dof]
    assert not rows[:, left].any()
