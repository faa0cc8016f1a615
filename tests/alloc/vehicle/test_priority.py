"""The key ``priority``: axes in levels, each axis in one of them."""

from dataclasses import replace
from pathlib import Path

import pytest

from alloc import list_vehicles, load_vehicle
from alloc.errors import VehicleError
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import VehicleFile, to_yaml
from tests.readers import written
from tests.vehicle_files import GOOD, refusal


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "my.yaml"


@pytest.mark.parametrize("key", ["", "priority: []\n"])
def test_left_out_it_is_one_level_with_all_axes(file: Path, key: str) -> None:
    assert load_vehicle(written(file, GOOD + key)).priority == (("surge", "sway", "yaw"),)


def test_levels_stand_as_they_are_written_also_after_a_fault(file: Path) -> None:
    vehicle = load_vehicle(written(file, GOOD + "priority: [[yaw], [sway, surge]]\n"))
    assert vehicle.priority == vehicle.with_fault(0).priority == (("yaw",), ("sway", "surge"))


@pytest.mark.parametrize(
    ("levels", "says"),
    [
        ("[[yaw], [surge]]", "sway is missing; put each axis"),
        ("[[yaw], [surge, sway], [yaw]]", "yaw stands twice; name each axis once"),
        ("[[yaw, yaw], [surge, sway]]", "yaw stands twice; name each axis once"),
        ("[[yaw], [surge, sway], []]", "level 3 is empty; name its axes, or leave it out"),
        ("[[yaw, roll], [surge, sway]]", "'roll' does not stand in 'dof'; give one of surge, sway, yaw"),
        ("[[yaw, turn], [surge, sway]]", "got 'turn', expected one of heave, pitch, roll, surge"),
        ("[yaw, surge, sway]", "priority[0]: got text, expected a list"),
        ("yaw", "priority: got text, expected a list"),
    ],
)
def test_what_is_no_priority_is_refused_with_line_and_remedy(file: Path, levels: str, says: str) -> None:
    message = refusal(written(file, f"{GOOD}priority: {levels}\n"))
    assert "line 9: priority" in message
    assert says in message


def test_a_vehicle_made_in_python_is_held_to_the_same() -> None:
    with pytest.raises(VehicleError, match="yaw is missing") as caught:
        replace(load_vehicle("ukwial"), priority=(("surge",), ("sway",)))
    assert caught.value.key == "priority"


def test_written_as_yaml_it_reads_back_the_same(file: Path) -> None:
    keys = VehicleFile(
        name="x", dof=["surge", "yaw"], f_min=-1, f_max=1, T=[[1, 1], [1, -1]], priority=[["yaw"], ["surge"]]
    )
    assert load_vehicle(written(file, to_yaml(keys))).priority == (("yaw",), ("surge",))


@pytest.mark.parametrize("name", list_vehicles())
def test_a_shipped_6_dof_vehicle_holds_depth_and_attitude_before_place_and_place_before_heading(
    name: str,
) -> None:
    vehicle = load_vehicle(name)
    if vehicle.dof == DOF:
        assert vehicle.priority == (("heave", "roll", "pitch"), ("surge", "sway"), ("yaw",))
    assert sorted(axis for level in vehicle.priority for axis in level) == sorted(vehicle.dof)
