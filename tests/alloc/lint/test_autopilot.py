"""Factors against geometry: shipped vehicles get no accusation, and each of many wrong ones is named."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from alloc import NotApplicable, build, load_vehicle
from alloc.errors import FileError, VehicleError
from alloc.files.ardupilot import read_parameters, sub_settings
from alloc.lint.autopilot import choose, on_autopilot, shares
from alloc.methods.px4 import unit_outputs
from alloc.vehicle.file import find_file, matrices, poses, read_document, vehicle_with
from alloc.vehicle.frame import TURN
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import AutopilotKeys, Thruster, VehicleFile

SHIPPED = ("bluerov2", "bluerov2-heavy")
Change = Callable[[list[Thruster]], None]


def keys_of(name: str) -> VehicleFile:
    """A shipped file's keys, with poses alone."""
    keys = read_document(find_file(name)).keys
    keys.T = None
    return keys


def remarks(keys: VehicleFile) -> list[str]:
    T, _ = matrices(keys)
    return [" ".join(remark) for remark in on_autopilot(vehicle_with(keys, T), poses(keys, T))]


def reverse(i: int) -> Change:
    def change(thrusters: list[Thruster]) -> None:
        x, y, z = thrusters[i].direction
        thrusters[i].direction = (-x, -y, -z)

    return change


def turn(i: int, degrees: float) -> Change:
    def change(thrusters: list[Thruster]) -> None:
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        x, y, z = thrusters[i].direction
        thrusters[i].direction = (c * x - s * y, s * x + c * y, z)

    return change


def move(i: int, *metres: float) -> Change:
    def change(thrusters: list[Thruster]) -> None:
        x, y, z = np.array(thrusters[i].position) + metres
        thrusters[i].position = (x, y, z)

    return change


def swap(i: int, j: int) -> Change:
    def change(thrusters: list[Thruster]) -> None:
        thrusters[i], thrusters[j] = thrusters[j], thrusters[i]

    return change


WRONG = [
    ("bluerov2-heavy", reverse(0), ["thruster 0 pushes opposite", "MOT_1_DIRECTION = -1"]),
    ("bluerov2-heavy", reverse(5), ["thruster 5 pushes opposite", "MOT_5_DIRECTION = -1"]),
    ("bluerov2", reverse(0), ["thruster 0 pushes opposite", "MOT_1_DIRECTION = 1"]),
    ("bluerov2", reverse(4), ["thruster 4 pushes opposite", "MOT_5_DIRECTION = 1"]),
    ("bluerov2", reverse(3), ["thruster 3 pushes opposite", "MOT_4_DIRECTION = -1"]),
    ("bluerov2-heavy", turn(1, 90), ["thruster 1 contradicts motor 2"]),
    ("bluerov2", turn(2, 90), ["thruster 2 contradicts motor 3"]),
    ("bluerov2-heavy", turn(2, 10), ["thruster 2 is no mirror image"]),
    ("bluerov2", turn(3, 10), ["thruster 3", "no mirror image", "10.0 deg"]),
    ("bluerov2-heavy", move(0, 0.01, 0, 0), ["thruster 0 is no mirror image", "7 mm"]),
    ("bluerov2-heavy", move(3, 0, 0.01, 0), ["thruster 3 is no mirror image"]),
    ("bluerov2-heavy", move(1, 0, 0, 0.01), ["thruster 1 is no mirror image", "10 mm"]),
    ("bluerov2-heavy", move(0, 0.05, 0, 0), ["thruster 0 is no mirror image", "35 mm"]),
    ("bluerov2-heavy", move(6, 0, 0.01, 0), ["thruster 6 is no mirror image", "10 mm"]),
    ("bluerov2", move(1, 0.01, 0, 0), ["thruster 1", "no mirror image"]),
    ("bluerov2", move(5, 0.01, 0, 0), ["thruster 5", "no mirror image"]),
    ("bluerov2", move(2, 0, 0, 0.05), ["thruster 2", "no mirror image", "50 mm"]),
    ("bluerov2-heavy", swap(0, 1), ["thruster 0 is wired as motor 1", "SERVOn_FUNCTION = 34"]),
    ("bluerov2", swap(0, 3), ["thruster 0 is wired as motor 1", "thruster 3 is wired as motor 4"]),
    ("bluerov2-heavy", swap(0, 4), ["thruster 0 is wired as motor 1", "thruster 4 is wired as motor 6"]),
    ("bluerov2-heavy", swap(4, 7), ["thruster 4 is wired as motor 6", "thruster 7 is wired as motor 7"]),
]


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("frame", ["frd", "flu"])
def test_a_vehicle_that_fits_its_frame_gets_no_accusation(name: str, frame: str) -> None:
    keys = keys_of(name)
    assert keys.thrusters is not None
    if keys.frame != frame:
        keys.frame = "flu" if frame == "flu" else "frd"
        for each in keys.thrusters:
            x, y, z = TURN * each.position
            a, b, c = TURN * each.direction
            each.position, each.direction = (x, y, z), (a, b, c)
    assert remarks(keys) == []


@pytest.mark.parametrize(("name", "change", "says"), WRONG)
def test_each_wrong_vehicle_is_named(name: str, change: Change, says: list[str]) -> None:
    keys = keys_of(name)
    assert keys.thrusters is not None
    change(keys.thrusters)
    keys.rank = None if keys.rank is None else keys.rank
    said = remarks(keys)
    assert said
    for words in says:
        assert any(words in line for line in said), said


@pytest.mark.parametrize(("i", "parameter"), [(0, "MOT_1"), (2, "MOT_3"), (5, "MOT_5"), (7, "MOT_7")])
def test_the_parameter_that_is_named_mends_the_vehicle(i: int, parameter: str) -> None:
    keys = keys_of("bluerov2-heavy")
    assert keys.thrusters is not None
    assert keys.autopilot is not None
    reverse(i)(keys.thrusters)
    (line,) = remarks(keys)
    assert f"{parameter}_DIRECTION = -1" in line
    keys.autopilot.reversed = [i]
    assert remarks(keys) == []


def ninety() -> list[Thruster]:
    """Thrusters that fit VECTORED_6DOF_90DEG, in the order of its motors, in frd."""
    up, ahead, side = (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    places = [(0.2, -0.2), (0, -0.2), (-0.2, -0.2), (0.1, 0), (-0.1, 0), (0.2, 0.2), (0, 0.2), (-0.2, 0.2)]
    ways = [up, ahead, up, side, side, up, ahead, up]
    return [Thruster((x, y, 0.0), way) for (x, y), way in zip(places, ways, strict=True)]


def test_another_frame_s_wiring_is_named_with_the_frame_that_fits() -> None:
    keys = keys_of("bluerov2-heavy")
    keys.thrusters, keys.autopilot = ninety(), AutopilotKeys(ardusub="VECTORED_6DOF")
    (line,) = remarks(keys)
    assert "FRAME_CONFIG = 3 (VECTORED_6DOF_90DEG)" in line
    keys.autopilot = AutopilotKeys(ardusub="VECTORED_6DOF_90DEG")
    assert remarks(keys) == []


@pytest.mark.parametrize("side", [0.02, -0.02])
def test_a_payload_on_one_side_is_named_with_its_side(side: float) -> None:
    keys = keys_of("bluerov2-heavy")
    keys.center_of_mass = (0.0, side, 0.0)
    (line,) = remarks(keys)
    assert f"lies 20 mm to {'starboard' if side > 0 else 'port'} of the thrusters' middle" in line


def test_an_axis_that_the_frame_can_t_command_is_a_note() -> None:
    keys = keys_of("bluerov2-heavy")
    keys.autopilot, keys.dof = (
        AutopilotKeys(ardusub="VECTORED"),
        ["surge", "sway", "heave", "roll", "pitch", "yaw"],
    )
    assert keys.thrusters is not None
    keys.thrusters[4:] = [
        Thruster((0.1, 0.2, 0.0), (0.0, 0.0, 1.0)),
        Thruster((0.1, -0.2, 0.0), (0.0, 0.0, 1.0)),
    ]
    keys.rank = 6
    assert any(line.startswith("note") and "VECTORED commands no pitch" in line for line in remarks(keys))


def test_the_shares_are_forces_and_moments_of_each_input_added_up_thruster_by_thruster() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    assert vehicle.autopilot is not None
    assert vehicle.poses is not None
    table, size = shares(vehicle, vehicle.autopilot, vehicle.autopilot.factors), 50.0
    for column, way in enumerate([1, 1, -1, 1, 1, 1]):
        made = np.zeros(6)
        for i, factors in enumerate(vehicle.autopilot.factors):
            made += vehicle.poses[:, i] * size * factors[column]
        most = (np.abs(vehicle.poses[column]) * size).sum()
        assert table[column, column] == pytest.approx(100 * way * made[column] / most)
    assert np.abs(table - np.diag(np.diag(table))).max() < 1e-9
    assert DOF[0] == "surge"


PARAMETERS = "# ArduSub\nFRAME_CONFIG,2\nMOT_1_DIRECTION,1\nMOT_3_DIRECTION,-1\nMOT_FV_CPLNG_K,0.8\n"


@pytest.mark.parametrize(
    "text",
    [PARAMETERS, PARAMETERS.replace(",", " "), PARAMETERS.replace(",", "\t").replace("\n", "\t6\n1\t1\t")],
    ids=["mission planner", "mavproxy", "qgroundcontrol"],
)
def test_a_parameter_file_says_frame_directions_and_coupling(text: str, tmp_path: Path) -> None:
    file = tmp_path / "rov.param"
    file.write_text(text)
    assert sub_settings(read_parameters(file), file) == (2, (3,), 0.8)
    keys = choose(str(file), keys_of("bluerov2-heavy").autopilot)
    assert (keys.ardusub, keys.reversed, keys.coupling) == ("VECTORED_6DOF", [2], 0.8)
    assert keys.motors == [0, 1, 2, 3, 5, 4, 7, 6]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("FRAME_CLASS,1\nMOT_SPIN_ARM,0.1\n", "it has FRAME_CLASS, so it is no ArduSub's"),
        ("SYSID,1\n", "of 1 parameters none"),
        ("hello\n", "holds no parameters"),
        ("CA_AIRFRAME,0\n", "CA_AIRFRAME is 0, expected 7"),
        ("CA_METHOD,3\n", "CA_METHOD is 3; give 0, 1 or 2"),
        ("MC_AIRMODE,3\n", "MC_AIRMODE is 3; give 0, 1 or 2"),
        ("MC_AIRMODE_LIM,0.2\n", "MC_AIRMODE_LIM is 0.2, of PX4 after v1.17; leave it out"),
    ],
)
def test_another_vehicle_s_parameters_are_refused(text: str, says: str, tmp_path: Path) -> None:
    file = tmp_path / "copter.param"
    file.write_text(text)
    with pytest.raises(FileError, match=says):
        choose(str(file), None)


def test_a_parameter_file_of_px4_says_method_airmode_and_rotors(tmp_path: Path) -> None:
    file = tmp_path / "rov.params"
    file.write_text("1\t1\tCA_AIRFRAME\t7\t6\n1\t1\tMC_AIRMODE\t1\t6\n1\t1\tCA_ROTOR_COUNT\t8\t6\n")
    keys = choose(str(file), None)
    assert keys == AutopilotKeys(px4="automatic", airmode=1, motors=list(range(8)))
    heavy, other = keys_of("bluerov2-heavy"), keys_of("bluerov2")
    heavy.autopilot = other.autopilot = keys
    mixer = vehicle_with(heavy, matrices(heavy)[0]).autopilot
    assert mixer is not None
    assert mixer.airmode == 1
    with pytest.raises(VehicleError, match="autopilot: PX4 has 8 motors, the vehicle 6 thrusters"):
        vehicle_with(other, matrices(other)[0])
    file.write_text("CA_METHOD,0\nMC_AIRMODE,2\n")
    assert choose(str(file), None) == AutopilotKeys(px4="pseudoinverse")


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        ("ardusub:VECTERED", "no frame 'VECTERED'; did you mean VECTORED"),
        ("px5", "got 'px5', expected ardusub:FRAME, px4, key"),
        ("key", "the file has no key 'autopilot'"),
    ],
)
def test_an_unknown_autopilot_is_refused_with_what_there_is(spec: str, says: str) -> None:
    with pytest.raises(VehicleError, match=says):
        choose(spec, None)


@pytest.mark.parametrize(
    ("said", "says"),
    [
        (AutopilotKeys(ardusub="VECTORED", px4="automatic"), "got both of ardusub and px4, expected one"),
        (AutopilotKeys(), "got neither of ardusub and px4"),
        (AutopilotKeys(px4="automatic", airmode=3), "airmode is 3; give 0, 1 or 2"),
        (AutopilotKeys(ardusub="VECTORED", airmode=1), "airmode is 1; px4: automatic alone reads it"),
        (AutopilotKeys(px4="wls"), "no CA_METHOD 'wls'; there are automatic, pseudoinverse"),
    ],
)
def test_a_key_that_names_no_one_mixer_is_refused(said: AutopilotKeys, says: str) -> None:
    keys = keys_of("bluerov2")
    keys.autopilot = said
    with pytest.raises(VehicleError, match=says):
        vehicle_with(keys, matrices(keys)[0])


def test_px4_is_not_accused_of_factors_and_its_roll_reaches_as_far_as_its_scale_lets_it() -> None:
    """Roll and pitch of a BlueROV2 Heavy share a scale, so that roll at 1 is less than its thrusters do."""
    keys = keys_of("bluerov2-heavy")
    keys.autopilot = choose("px4", keys.autopilot)
    assert keys.autopilot == AutopilotKeys(px4="automatic")
    assert [one for one in remarks(keys) if one.startswith("warning")] == []
    T, _ = matrices(keys)
    vehicle = vehicle_with(keys, T)
    assert vehicle.autopilot is not None
    mix = np.linalg.pinv(T * vehicle.f_max)
    roll, pitch = (float(np.sqrt(mix[:, j] @ mix[:, j] / 2)) for j in (3, 4))  # of four thrusters each
    u = mix[:, 3] / max(roll, pitch)
    share = np.abs(T[3] * vehicle.f_max) @ np.abs(u) / np.abs(T[3] * vehicle.f_max).sum()
    table = shares(vehicle, vehicle.autopilot, unit_outputs(vehicle))
    assert table[3, 3] == pytest.approx(100 * share, rel=1e-6)
    with pytest.raises(NotApplicable, match="has PX4 as its autopilot; write autopilot"):
        build("ardusub", vehicle)


def test_a_frame_number_without_a_table_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "rov.param"
    file.write_text("FRAME_CONFIG,7\n")
    with pytest.raises(FileError, match="FRAME_CONFIG is 7; there are 0 to 6, BLUEROV1 to SIMPLEROV_5"):
        choose(str(file), None)
