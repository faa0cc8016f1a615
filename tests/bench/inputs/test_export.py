"""Vehicles exported to files of other projects, and vehicle files written anew, read back the same."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, list_vehicles, load_vehicle
from alloc.vehicle.file import build_vehicle, find_file, read_document, suspects
from alloc.vehicle.keys import to_yaml
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
