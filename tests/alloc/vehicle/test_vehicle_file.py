"""Vehicle files that are accepted: spellings, frames, matrices beside poses, and names."""

import re
from pathlib import Path

import numpy as np
import pytest

from alloc import list_vehicles, load_vehicle
from alloc.errors import VehicleError
from alloc.vehicle.file import find_file, matrices, poses, read_document, suspects
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF, pose_matrix
from tests.places import DOCS
from tests.readers import written
from tests.vehicle_files import GOOD, refusal

POSES = """\
name: box
dof: [surge, sway, heave, roll, pitch, yaw]
thrusters:
  - {position: [0.4, 0.3, 0.1], direction: [1, 0, 0]}
  - {position: [0.4, -0.3, 0.1], direction: [1, 0, 0]}
  - {position: [0.3, 0.1, 0.0], direction: [0, 1, 0]}
  - {position: [-0.3, 0.1, 0.0], direction: [0, 1, 0]}
  - {position: [0.2, 0.2, 0.0], direction: [0, 0, 1]}
  - {position: [0.2, -0.2, 0.0], direction: [0, 0, 1]}
  - {position: [-0.2, 0.2, 0.0], direction: [0, 0, 1]}
center_of_mass: [0.01, 0.02, 0.03]
f_min: -10
f_max: 10
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "my.yaml"


def with_matrix(text: str, T: np.ndarray) -> str:
    return text + "T:\n" + "".join(f"  - {row}\n" for row in T.tolist())


def test_a_file_gives_its_matrix_and_limits_and_the_defaults_of_h_and_q(file: Path) -> None:
    vehicle = load_vehicle(written(file, GOOD))
    np.testing.assert_array_equal(vehicle.T, [[1, 1, 0, 0], [0, 0, 1, 1], [-0.5, 0.5, 1, -1]])
    np.testing.assert_array_equal(vehicle.f_min, [-10] * 4)
    np.testing.assert_array_equal(vehicle.f_max, [20] * 4)
    np.testing.assert_array_equal(vehicle.H, np.eye(4))
    np.testing.assert_array_equal(vehicle.slack_weights, [2000] * 3)


@pytest.mark.parametrize(
    "spelled",
    [
        "\ufeff" + GOOD,
        GOOD.replace("\n", "\r\n"),
        GOOD.replace("-10", "-1e1").replace("20", "2E+1"),
        GOOD.replace("-10", "-10.").replace("20", "0x14"),
        GOOD.replace("f_max: 20", "f_max: [20, 20, 20, 20]"),
        "%YAML 1.2\n---\n" + GOOD + "...\n",
        GOOD.replace("f_min: -10", "f_min: &low -10") + "notes: []\n",
        GOOD + "weights: [1, 1, 1, 1]\n",
        GOOD + "source: 2004-01-01\n",
        GOOD + "rank: 3\n",
    ],
    ids=[
        "byte order mark",
        "CRLF",
        "exponents",
        "hex",
        "lists",
        "directives",
        "an anchor",
        "weights",
        "a date as text",
        "rank",
    ],
)
def test_another_spelling_gives_an_equal_vehicle(file: Path, spelled: str) -> None:
    expected = load_vehicle(written(file, GOOD))
    vehicle = load_vehicle(written(file, spelled))
    for key in ("T", "H", "f_min", "f_max", "slack_weights"):
        np.testing.assert_array_equal(getattr(vehicle, key), getattr(expected, key))


def test_an_exponent_without_a_dot_is_a_number(file: Path) -> None:
    """YAML 1.1 reads 1e-5 as text."""
    vehicle = load_vehicle(written(file, GOOD.replace("-0.5, 0.5", "-1e-5, 1e-5")))
    assert vehicle.T[2, 0] == -1e-5


def test_naming_a_frame_turns_no_number(file: Path) -> None:
    """T = [d; r x d] holds in any right-handed frame, so a file's numbers are a vehicle's as they stand."""
    for text in (POSES, GOOD):
        here = load_vehicle(written(file, text))
        there = load_vehicle(written(file, text + "frame: flu\n"))
        np.testing.assert_array_equal(here.T, there.T)
        assert (here.frame, there.frame) == ("frd", "flu")


def test_a_vehicle_in_the_other_frame_has_its_poses_turned(file: Path) -> None:
    """The turned T is the T of positions, directions and centre of mass turned one by one."""
    here = load_vehicle(written(file, POSES))
    there = here.with_frame("flu")
    turn = np.diag([1.0, -1.0, -1.0])
    positions = np.array([[0.4, 0.3, 0.1], [0.4, -0.3, 0.1], [0.3, 0.1, 0], [-0.3, 0.1, 0], [0.2, 0.2, 0]])
    directions = np.array([[1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0], [0, 0, 1.0]])
    expected = pose_matrix(positions @ turn, directions @ turn, np.array([0.01, 0.02, 0.03]) @ turn)
    np.testing.assert_allclose(there.T[:, :5], expected, atol=1e-15)
    np.testing.assert_array_equal(there.with_frame("frd").T, here.T)
    assert here.with_frame("frd") is here
    with pytest.raises(VehicleError, match="unknown frame 'ned'; expected frd or flu"):
        here.with_frame("ned")


def test_a_matrix_beside_poses_that_make_it_is_accepted_to_its_printed_digits(file: Path) -> None:
    skew = POSES.replace(
        "[0.4, 0.3, 0.1], direction: [1, 0, 0]", "[0.4, 0.3, 0.1], direction: [0.7071, 0.7071, 0]"
    )
    T = load_vehicle(written(file, skew)).T
    assert np.abs(T - T.round(2)).max() > 2e-3
    vehicle = load_vehicle(written(file, with_matrix(skew, T.round(2))))
    np.testing.assert_array_equal(vehicle.T, T.round(2))  # the written T counts, not that of the poses


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda T: T * [[1], [1], [1], [1], [-1], [1]], "the pitch row has the opposite sign"),
        (lambda T: turned(T, DOF), "in different frames"),
        (lambda T: T + 0.1 * np.eye(6, 7, 3), "surge of thruster 3 is 0.1, but its pose makes 0"),
    ],
)
def test_a_matrix_that_contradicts_its_poses_is_refused(file: Path, spoil, says: str) -> None:  # type: ignore[no-untyped-def]
    T = load_vehicle(written(file, POSES)).T
    message = refusal(written(file, with_matrix(POSES, spoil(T))))
    assert "line 14: T: " in message
    assert says in message


def test_a_row_that_holds_only_rounding_does_not_count_for_the_rank(file: Path) -> None:
    """cos 90 deg is 6e-17 in floats, though a thruster across does not push ahead."""
    text = "name: a\ndof: [surge, sway]\nplanar: {alpha_deg: [90, -90], d: [1, 2], phi_deg: [0, 0]}\n"
    assert "rank 1 but 2" in refusal(written(file, text + "f_min: -1\nf_max: 1\n"))
    degenerate = load_vehicle(written(file, text + "f_min: -1\nf_max: 1\nrank: 1\n"))
    assert degenerate.rank == 1


def test_a_shipped_name_wins_over_a_file_of_that_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "ukwial", GOOD)
    assert load_vehicle("ukwial").name == "ukwial"
    assert load_vehicle("./ukwial").name == "cross"
    assert "ukwial" in list_vehicles()


def test_thrusters_have_the_names_of_their_poses_or_of_the_key_names(file: Path) -> None:
    named = load_vehicle(written(file, GOOD + "names: [port, starboard, bow, stern]\n"))
    assert named.names == ("port", "starboard", "bow", "stern")
    posed = POSES.replace("- {position", "- {name: lift, position", 1)
    assert load_vehicle(written(file, posed)).names == ("lift", "", "", "", "", "", "")
    assert load_vehicle(written(file, POSES)).names == ()


def test_a_thruster_s_name_is_as_good_as_its_index(file: Path) -> None:
    vehicle = load_vehicle(written(file, GOOD + "names: [port, starboard, bow thruster, '']\n"))
    np.testing.assert_array_equal(
        vehicle.with_fault("bow thruster", 0.4).readiness, vehicle.with_fault(2, 0.4).readiness
    )
    assert [vehicle.called(i) for i in range(4)] == ["port", "starboard", "bow thruster", "thruster 3"]
    assert vehicle.with_fault("port").names == vehicle.names


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ("names: [a, b]", "2 for 4 thrusters"),
        ("names: [a, a, b, c]", "'a' stands twice"),
        ("names: ['3', a, b, c]", "'3' can't be typed"),
        ("names: ['a@1', b, c, d]", "'a@1' can't be typed"),
        ("names: [each, b, c, d]", "'each' can't be typed"),
        ("names: [' a', b, c, d]", "' a' can't be typed"),
        (f"names: [{'a' * 41}, b, c, d]", "up to 40 printable characters"),
        ("names: ['+1', a, b, c]", "'+1' can't be typed"),
        ("names: ['-0', a, b, c]", "'-0' can't be typed"),
    ],
)
def test_names_that_could_not_be_typed_or_told_apart_are_refused(file: Path, keys: str, says: str) -> None:
    """``--fault`` takes numbers, names, and ``@`` before a readiness; CSV headers hold commas and quotes."""
    message = refusal(written(file, GOOD + keys + "\n"))
    assert says in message
    assert "line 9" in message


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (
            "f1, f2, f3, f4",
            "'f1' is thruster 0, but columns f1_min and u1 are another's; count from 0",
        ),
        ("f1, f2, f3, f0", "'f1' is thruster 0"),
        ("bow, '', u2, U07", "'U07' is thruster 3, but .* as in U3, or take another letter: t07"),
        ("f0, f1, F4, f3", "'F4' is thruster 2"),
        ("bow, stern, port, f20", "'f20' is thruster 3"),
    ],
)
def test_a_name_that_is_another_thruster_s_column_is_refused(file: Path, names: str, says: str) -> None:
    """``f1_min`` is the second thruster's limit, and would be the first's by its name."""
    assert re.search(says, refusal(written(file, f"{GOOD}names: [{names}]\n")))


@pytest.mark.parametrize("names", ["f0, F1, u2, U03", "t1, t2, t3, t4", "fan1, uf0, 2f, f-1"])
def test_a_name_with_a_number_that_misleads_nobody_is_taken(file: Path, names: str) -> None:
    vehicle = load_vehicle(written(file, f"{GOOD}names: [{names}]\n"))
    assert list(vehicle.names) == names.split(", ")
    assert [vehicle.index(name) for name in vehicle.names] == [0, 1, 2, 3]


def test_names_beside_named_poses_are_refused(file: Path) -> None:
    named = POSES.replace("- {position", "- {name: lift, position", 1)
    names = ", ".join("abcdefg")
    assert "keep one of the two" in refusal(written(file, f"{named}names: [{names}]\n"))


@pytest.mark.parametrize(
    ("wanted", "says"),
    [("bow thrustr", "did you mean bow thruster?"), ("stern", "there are port, starboard, bow thruster")],
)
def test_a_name_that_no_thruster_has_is_refused_with_those_there_are(
    file: Path, wanted: str, says: str
) -> None:
    vehicle = load_vehicle(written(file, GOOD + "names: [port, starboard, bow thruster, '']\n"))
    with pytest.raises(VehicleError, match=re.escape(says)):
        vehicle.with_fault(wanted)
    with pytest.raises(VehicleError, match="nor any other; give a number"):
        load_vehicle(written(file, GOOD)).with_fault(wanted)


FILES = [find_file(name) for name in list_vehicles()] + [DOCS / "vehicles" / "box8.yaml"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_poses_make_the_t_that_they_come_from(path: Path) -> None:
    """T of the poses about the centre of mass is the file's own; published matrices have three digits."""
    keys = read_document(path).keys
    T, _ = matrices(keys)
    positions, directions, center, measured, stands = poses(keys, T)
    assert {*np.flatnonzero(~stands).tolist()} == suspects(keys, len(stands))
    assert measured == (keys.T is None or keys.thrusters is not None)
    made = pose_matrix(positions, directions, center)[[DOF.index(axis) for axis in keys.dof]]
    kept = [axis in ("surge", "sway", "heave", "yaw") for axis in keys.dof]
    largest = np.abs(T).max(axis=1)
    off = (np.abs(made - T) * stands).max(axis=1) / largest
    assert (off[kept] < 0.02).all()
    if keys.T is None:
        assert (off < 1e-9).all()
