"""Files of ``thrustbench init``: they are read, checked and run at once."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from alloc import Label, Status, build, label, list_vehicles, load_vehicle
from alloc.discovery import load_plugin, prepare
from alloc.errors import VehicleError
from alloc.lint.check import check_vehicle
from bench.__main__ import cli
from bench.inputs.demand_csv import read_demands
from bench.inputs.faults import EACH, GivenFault, faulty, parse_fault, with_fault
from bench.inputs.starter import name_places, sketch_keys


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def init(*arguments: str, answers: str = "") -> Result:
    return CliRunner().invoke(cli, ["init", *arguments], input=answers, standalone_mode=False)


@pytest.mark.parametrize("name", list_vehicles())
def test_a_copy_of_a_shipped_vehicle_allocates_as_that_does(name: str, here: Path) -> None:
    """Poses of three or four digits make T within a percent, so thrusts agree as well as that."""
    assert init("my-rov", "--like", name).exception is None
    mine, shipped = load_vehicle("my-rov.yaml"), load_vehicle(name)
    assert (mine.name, mine.dof) == ("my-rov", shipped.dof)
    largest = np.abs(shipped.T).max(axis=1, keepdims=True)
    assert (np.abs(mine.T - shipped.T) <= 0.01 * largest).all()
    np.testing.assert_array_equal(mine.f_max, shipped.f_max)
    assert check_vehicle("my-rov.yaml").count("error") == 0


@pytest.mark.parametrize("name", list_vehicles())
def test_its_demands_push_each_axis_alone_then_more_than_the_vehicle_can_do(name: str, here: Path) -> None:
    init("my-rov", "--like", name)
    vehicle = load_vehicle("my-rov.yaml")
    t, taus, said, *_ = read_demands(Path("demands.csv"), vehicle.dof)
    assert t is not None
    assert said == ""
    np.testing.assert_array_equal(taus[: vehicle.k] > 0, np.eye(vehicle.k, dtype=bool))
    labels = label(vehicle, taus).label
    assert (labels[:-1] != Label.INFEASIBLE).all()
    assert labels[-1] == Label.INFEASIBLE
    allocate = build("nullspace", vehicle)
    assert [allocate(tau).status for tau in taus] == [Status.SOLVED] * (len(taus) - 1) + [Status.INFEASIBLE]


def test_its_plug_in_is_a_method_that_keeps_the_limits(here: Path) -> None:
    init("my-rov", "--like", "bluerov2-heavy")
    vehicle = load_vehicle("my-rov.yaml")
    allocate = prepare(load_plugin(Path("my_allocator.py")), vehicle)
    assert allocate.limited
    tau = vehicle.T @ np.ones(8)
    clipped = build("clip", vehicle)(tau).f
    np.testing.assert_allclose(allocate(tau).f, clipped, atol=1e-12)  # two ways to T*


def test_a_vehicle_is_made_of_a_few_answers(here: Path) -> None:
    assert init("mine", answers="0.6\n0.4\n30\n2\n50\n35\n").exception is None
    vehicle = load_vehicle("mine.yaml")
    assert vehicle.dof == ("surge", "sway", "heave", "roll", "yaw")
    assert vehicle.names[-1] == "vertical port"
    front_starboard = vehicle.T[:, 0]
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    np.testing.assert_allclose(front_starboard, [c, -s, 0, 0, -0.3 * s - 0.2 * c], atol=1e-4)
    assert (vehicle.f_min[0], vehicle.f_max[0]) == (-35, 50)


@pytest.mark.parametrize("angle", [0, 45])
@pytest.mark.parametrize("vertical", [0, 1, 2, 4])
def test_every_sketch_is_a_vehicle_without_warnings_of_its_making(
    angle: float, vertical: int, here: Path
) -> None:
    init("mine", answers=f"0.6\n0.4\n{angle}\n{vertical}\n50\n35\n")
    report = check_vehicle("mine.yaml")
    assert [f.message for f in report.findings if f.level != "note" and "without" not in f.message] == []
    assert len(set(load_vehicle("mine.yaml").names)) == load_vehicle("mine.yaml").n


def test_a_name_that_ends_as_the_file_will_is_not_given_a_second_ending(here: Path) -> None:
    assert init("rov.yaml", "--like", "ukwial").exception is None
    assert load_vehicle("rov.yaml").name == "rov"


def test_nothing_is_replaced(here: Path) -> None:
    (here / "demands.csv").write_text("mine")
    result = init("my-rov", "--like", "ukwial")
    assert "demands.csv: is there already" in str(result.exception)
    assert [path.name for path in here.iterdir()] == ["demands.csv"]


@pytest.mark.parametrize("name", ["../x", "", "a b", "-x", "x" * 41, "7seas"])
def test_a_name_that_is_no_file_s_is_refused(name: str, here: Path) -> None:
    assert isinstance(init("--like", "ukwial", "--", name).exception, VehicleError)
    assert list(here.iterdir()) == []


def test_answers_that_no_vehicle_has_are_refused_and_none_at_all_name_the_option(here: Path) -> None:
    for wrong in ((0, 0.4, 45, 4, 50, 35), (0.6, 0.4, 90, 4, 50, 35), (0.6, 0.4, 45, 3, 50, 35)):
        with pytest.raises(VehicleError):
            sketch_keys("mine", *wrong)  # type: ignore[arg-type]
    assert "give --like VEHICLE" in str(init("mine").exception)


def test_places_are_named_by_where_thrusters_sit() -> None:
    arms = np.array([[1.0, 1, 0], [-1, -1, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1], [1, 0, 0]])
    ways = np.array([[1.0, 0, 0], [0.7, 0.7, 0], [0, 0, 1], [1, 0, 0], [1, 0, 0], [0, 1, 0]])
    assert name_places(arms, ways) == [
        "front starboard",
        "rear port",
        "vertical starboard",
        "middle 1",
        "middle 2",
        "lateral front",
    ]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("3", GivenFault(3)),
        ("3@0.4", GivenFault(3, 0.4)),
        ("vertical starboard", GivenFault("vertical starboard")),
        ("vertical starboard@0.4", GivenFault("vertical starboard", 0.4)),
        ("-1", GivenFault(-1)),
        ("each", EACH),
    ],
)
def test_a_fault_is_a_thruster_and_what_is_left_of_it(text: str, fault: GivenFault) -> None:
    assert parse_fault(text) == fault


@pytest.mark.parametrize("text", ["3@", "3@x", "bow@@1"])
def test_a_readiness_that_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(VehicleError, match=r"as in 3@0\.4"):
        parse_fault(text)


def test_each_is_every_working_thruster_off_in_turn() -> None:
    vehicle = load_vehicle("ukwial")
    assert [v.name for v in with_fault(vehicle, EACH)] == [f"ukwial-f{i}" for i in range(4)]
    assert [v.name for v in with_fault(vehicle.with_fault(1), EACH)] == [f"ukwial-f1-f{i}" for i in (0, 2, 3)]
    assert [v.name for v in faulty(vehicle, [None, GivenFault(2, 0.5)])] == ["ukwial", "ukwial-f2@0.5"]


def test_a_thruster_that_the_vehicle_lacks_is_refused() -> None:
    for fault in (GivenFault(-1), GivenFault(4), GivenFault("bow")):
        with pytest.raises(VehicleError):
            with_fault(load_vehicle("ukwial"), fault)
