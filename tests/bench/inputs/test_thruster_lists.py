"""Lists and tables of thrusters under other projects' keys, and options and matrices that stand otherwise."""
# ruff: noqa: E501 - a YAML entry stays on its line

from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError
from alloc.vehicle.geometry import pose_matrix
from bench.inputs.imported import ImportOptions, import_vehicle
from tests.foreign_vehicles import LIMITS, imported, vehicle_of
from tests.mutations import damaged
from tests.readers import refused

S = float(np.sqrt(0.5))
POSITIONS = np.array(
    [[0.2, 0.1, 0], [0.2, -0.1, 0], [-0.2, 0.1, 0], [-0.2, -0.1, 0], [0, 0.15, 0.05], [0, -0.15, 0]]
)
RPY = np.array([[0, 0, -45], [0, 0, 45], [0, 0, 135], [0, 0, -135], [0, -90, 0], [30, -90, 0]])
DIRECTIONS = np.array([[S, -S, 0], [S, S, 0], [-S, S, 0], [-S, -S, 0], [0, 0, 1], [0, 0, 1]])
HALF = np.radians([-45, 45, 135, -135]) / 2
QUATERNIONS = [*([0, 0, float(np.sin(a)), float(np.cos(a))] for a in HALF), [0, -S, 0, S], [0, -S, 0, S]]
"""x, y, z, w of the directions, as the half angle formula has them."""


def listing(
    key: str, values: object, position: str = "pos", head: str = "thrusters:\n", extra: str = ""
) -> str:
    """YAML of the six thrusters with their directions under a key."""
    rows = zip(POSITIONS.tolist(), values, strict=True)  # type: ignore[call-overload]  # arrays and lists
    return head + "".join(
        f"  - {{name: t{i}, {position}: {place}, {key}: {value}{extra}}}\n"
        for i, (place, value) in enumerate(rows)
    )


WAYS = {
    "rpy in degrees": listing("rpy", RPY.tolist()),
    "rpy in rad": listing("rpy", np.radians(RPY).round(4).tolist()),
    "rpy_deg": listing("rpy_deg", RPY.tolist()),
    "direction": listing("direction", (2 * DIRECTIONS).tolist(), "position"),
    "axis": listing("axis", DIRECTIONS.tolist(), "xyz", head="rov:\n propulsion:\n"),
    "quaternion_xyzw": listing("quaternion_xyzw", QUATERNIONS),
    "quat_wxyz": listing("quat_wxyz", [[w, x, y, z] for x, y, z, w in QUATERNIONS]),
    "orientation by letters": listing("orientation", [dict(zip("xyzw", q, strict=True)) for q in QUATERNIONS]).replace("'", ""),
    "orientation in rpy": listing("orientation", [dict(zip(("roll", "pitch", "yaw"), a, strict=True)) for a in RPY.tolist()]).replace("'", ""),
    "in a pose": listing("rpy", RPY.tolist()).replace(", pos", ", pose: {pos").replace("]}", "]}}"),
    "table": listing("rpy", RPY.tolist()).replace("- {name: ", "").replace(", pos", ": {pos"),
    "beside a camera": listing("rpy", RPY.tolist()) + "cameras: [{name: eye, pos: [1, 2, 3], rpy: [0, 0, 0]}]\n",
}  # fmt: skip


@pytest.mark.parametrize("text", WAYS.values(), ids=WAYS)
def test_thrusters_with_a_position_and_a_direction_are_read_under_any_key(tmp_path: Path, text: str) -> None:
    keys = imported(tmp_path, text, LIMITS)
    assert [thruster.name for thruster in keys.thrusters or ()] == [f"t{i}" for i in range(6)]
    vehicle = vehicle_of(keys, tmp_path)
    T = pose_matrix(POSITIONS, DIRECTIONS)
    rows = [("surge", "sway", "heave", "roll", "pitch", "yaw").index(axis) for axis in vehicle.dof]
    np.testing.assert_allclose(vehicle.T, T[rows], rtol=0, atol=1e-12)
    notes = " ".join(keys.notes)
    assert "Positions are in m" in notes
    assert "names no frame: frd" in notes
    assert ("thrust is along x of the rotated frame" in notes) == (
        "direction:" not in text and "axis:" not in text
    )


def test_millimetres_bounds_and_a_frame_are_taken_as_the_file_says_them(tmp_path: Path) -> None:
    text = listing("direction", DIRECTIONS.tolist(), extra=", thrust_bounds: [-80, 99.5], node_id: 3")
    for place in POSITIONS.tolist():
        text = text.replace(f"pos: {place}", f"pos_mm: {[1000 * x for x in place]}")
    keys = imported(tmp_path, "# frame: flu\n" + text)
    assert keys.thrusters is not None
    np.testing.assert_allclose([t.position for t in keys.thrusters], POSITIONS, rtol=0, atol=1e-12)
    assert (keys.f_min, keys.f_max, keys.frame) == (-80, 99.5, "flu")
    assert "Left out of each thruster: node_id." in keys.notes


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (listing("quaternion", QUATERNIONS), "got numbers in no stated order, expected keys; give x, y, z, w as keys"),
        (listing("orientation", QUATERNIONS), "got angles or a direction, expected one of them by its key; call it rpy_deg"),
        (listing("orientation", RPY.tolist()), "got angles or a direction, expected one of them by its key; call it rpy_deg"),
        (listing("rpy", (RPY / 45).tolist()), "rpy may be in degrees or radians; call it rpy_deg or rpy_rad"),
        (listing("rpy", RPY.tolist(), extra=", flipped: true"), "line 2: thrusters[0]: got flipped, of its axis or its driver's command, expected none"),
        (listing("rpy", RPY.tolist(), extra=", axis: [1, 0, 0]"), "thrusters[0]: got axis, rpy, expected one of"),
        (listing("rpy", RPY.tolist()).replace("name: t3, pos", "name: t3, at"), "line 5: thrusters[3]: got no position, expected one of"),
        (listing("rpy", RPY.tolist()).replace("0.2,", "200,"), "pos: got up to 200, expected m; if that is mm"),
        (listing("direction", (0 * DIRECTIONS).tolist()), "got 0, 0, 0, expected a direction x, y, z"),
        (listing("rpy", RPY.tolist()).replace("0, 45]", "45]"), "thrusters[1].rpy: got 2 numbers, expected roll, pitch, yaw"),
        (listing("quat_xyzw", (2 * np.array(QUATERNIONS)).tolist()), "got length 2, expected 1"),
        (listing("rpy", RPY.tolist(), head="a:\n") + listing("rpy", RPY.tolist(), head="b:\n"), "a, b have positions and directions"),
    ],
)  # fmt: skip
def test_what_a_list_leaves_open_is_refused_with_what_would_say_it(
    tmp_path: Path, text: str, says: str
) -> None:
    assert says in refused(lambda: imported(tmp_path, text, LIMITS), tmp_path / "theirs.yaml")


def test_a_vehicle_file_is_not_taken_for_a_list_of_thrusters(tmp_path: Path) -> None:
    text = "name: mine\ndof: [surge, sway]\nf_min: -1\nf_max: 1\n" + listing(
        "direction", DIRECTIONS.tolist(), "position"
    )
    assert "none of the known formats" in refused(lambda: imported(tmp_path, text), tmp_path / "theirs.yaml")


MVP = """\
generator_type: user
control_allocation_matrix:
  main: [0.0, 0.0, 0.1, 1.0, 0.0, 0.0]
  horizontal: [0.0, 0.0, 0.48, 0.0, 1.0, 0.0]
  vertical: [0.0, 0.39, 0.0, 0.0, 0.0, -1.0]
thruster_limits:
  main: {max: 40, min: -30}
  horizontal: {max: 20, min: -20}
  vertical: {max: 20, min: -20}
"""


def test_mvp_control_s_numbers_have_moments_first(tmp_path: Path) -> None:
    options = ImportOptions(dof=("yaw", "sway", "heave"))
    vehicle = vehicle_of(imported(tmp_path, MVP, options), tmp_path)
    np.testing.assert_array_equal(vehicle.T, [[0.1, 0.48, 0], [0, 1, 0], [0, 0, -1]])
    assert vehicle.names == ("main", "horizontal", "vertical")
    assert (vehicle.f_min.tolist(), vehicle.f_max.tolist()) == ([-30, -20, -20], [40, 20, 20])


@pytest.mark.parametrize(
    ("there", "put", "says"),
    [
        ("user", "tf", "generator_type is 'tf'"),
        ("0.1, 1.0, 0.0, 0.0]", "0.1, 1.0, 0.0]", "control_allocation_matrix.main: got 5 numbers, expected six: roll, pitch, yaw, surge"),
        ("{max: 40, min: -30}", "40", "no limits in it"),
    ],
)  # fmt: skip
def test_a_matrix_that_mvp_control_does_not_use_is_refused(
    tmp_path: Path, there: str, put: str, says: str
) -> None:
    assert says in refused(lambda: imported(tmp_path, MVP.replace(there, put)), tmp_path / "theirs.yaml")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("tam:\n" + "- [1, 0, 0, 0, 0, 0.1]\n" * 8, "tam: got 8 rows of six, one a thruster, expected six rows, surge to yaw; it is transposed"),
        ("tam: {t1: [1, 0, 0, 0, 0, 0.1], t2: [1, 0, 0, 0, 0, -0.1]}\n", "tam: got 2 rows of six, one a thruster"),
        ("tam:\n" + "- [1, 0, 0]\n" * 8, "tam: got 8 rows, expected six, surge to yaw"),
        ("m:\n  tam: {deadzone: 0.5, max_thrust: 40.0}\n", "tam has max_thrust, deadzone, options of thruster_manager"),
    ],
)  # fmt: skip
def test_a_tam_that_is_transposed_or_has_only_options_is_told_so(
    tmp_path: Path, text: str, says: str
) -> None:
    assert says in refused(lambda: imported(tmp_path, text, LIMITS), tmp_path / "theirs.yaml")


MANAGER = "m: {ros__parameters: {tam: {thruster_prefix: thr, deadzone: 0.5, min_thrust: -30.0, max_thrust: 40.0}}}\n"


def robot(names: tuple[str, ...]) -> str:
    """A URDF of a pair of propellers of these names, and of a wheel."""
    return (
        "<robot name='r'><link name='base_link'/>"
        + "".join(
            f"<link name='l{i}'/><joint name='{name}' type='continuous'><parent link='base_link'/><child link='l{i}'/>"
            f"<origin xyz='0 {0.2 - 0.4 * i} 0'/><axis xyz='1 0 0'/></joint>"
            for i, name in enumerate((*names, "wheel_propeller"))
        )
        + "</robot>"
    )


@pytest.mark.parametrize("thrusters", ["thruster_prefix: thr", "thrusters: [thr1, thr2]"])
def test_a_urdf_gets_joints_and_limits_of_thruster_manager_s_options(tmp_path: Path, thrusters: str) -> None:
    pytest.importorskip("urdf_parser_py", reason="needs the extra urdf")
    (tmp_path / "params.yaml").write_text(MANAGER.replace("thruster_prefix: thr", thrusters))
    options = ImportOptions(limits=tmp_path / "params.yaml")
    keys = imported(tmp_path, robot(("thr1", "thr2")), options, "r.urdf")
    assert [thruster.name for thruster in keys.thrusters or ()] == ["thr1", "thr2"]
    assert (keys.f_min, keys.f_max) == (-30, 40)
    assert "Limits are min_thrust and max_thrust of params.yaml, in N." in keys.notes
    assert any("deadzone 0.5 N is left out" in note for note in keys.notes)
    told = ImportOptions(limits=tmp_path / "params.yaml", f_min=-9, f_max=9)
    assert imported(tmp_path, robot(("thr1", "thr2")), told, "r.urdf").f_max == 9


def test_options_that_are_none_of_thruster_manager_s_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("urdf_parser_py", reason="needs the extra urdf")
    params = tmp_path / "params.yaml"
    options = ImportOptions(limits=params)
    for text, says in (
        ("tam: [[1]]\n", "has no tam with min_thrust, max_thrust, deadzone"),
        ("tam: {min_thrust: low}\n", "tam.min_thrust: got 'low', expected a number"),
    ):
        params.write_text(text)
        assert says in refused(lambda: imported(tmp_path, robot(("thr1", "thr2")), options, "r.urdf"), params)
    params.write_text(MANAGER.replace("-30.0", "0.0"))
    says = refused(
        lambda: imported(tmp_path, robot(("thr1", "thr2")), options, "r.urdf"), tmp_path / "r.urdf"
    )
    assert "no limits in it" in says
    assert "--limits is for URDF and SDF" in refused(
        lambda: imported(tmp_path, MVP, options), tmp_path / "theirs.yaml"
    )


@pytest.mark.parametrize("text", [WAYS["in a pose"], WAYS["orientation by letters"], MVP, MANAGER])
def test_a_damaged_file_is_read_or_refused_in_one_line(tmp_path: Path, text: str) -> None:
    rng = np.random.default_rng(5)
    messages = []
    for _ in range(60):
        (tmp_path / "theirs.yaml").write_bytes(damaged(text.encode(), rng))
        try:
            import_vehicle(tmp_path / "theirs.yaml", options=LIMITS)
        except AllocError as error:
            messages.append(str(error))
    assert len(messages) > 10
    assert [message for message in messages if "\n" in message or str(tmp_path) not in message] == []
