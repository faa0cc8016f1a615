"""Vehicle files that are refused, each in one line with file, line, key and remedy."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import AllocError, Vehicle, load_vehicle
from alloc.errors import UnknownName, VehicleError
from tests.readers import written
from tests.vehicle_files import GOOD, refusal


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "my.yaml"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "holds no keys"),
        ("# nothing but a comment\n", "holds no keys"),
        ("- 1\n- 2\n", "holds no keys"),
        ("just words", "holds no keys"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "line 1: not UTF-8 text"),
        (b"name: caf\xe9\n", "line 1: not UTF-8"),
        (GOOD.encode("utf-16"), "not UTF-8"),
        ("name: a\0b\n", "zero bytes"),
        ("name: \x07\n", "not valid YAML"),
        ("name: [1, 2\n", "not valid YAML"),
        (GOOD + "\tf_max: 1\n", "not valid YAML"),
        (GOOD + "---\n" + GOOD, "not valid YAML"),
        (GOOD + "f_max: 30\n", "line 9: key 'f_max' appears twice"),
        (GOOD.replace("cross", "!!python/object/apply:os.system [ls]"), "line 1: tag"),
        (GOOD.replace("-10", "!mine -10"), "line 7: tag '!mine' is not read"),
        (GOOD.replace("f_min: -10", "f_min: !mine [1, 2, 3, 4]"), "line 7: tag '!mine' is not read"),
        ("? [a, b]\n: 1\n", "line 1: a key is a list"),
        ("[" * 3000, "nested too deeply"),
        ("[" * 30 + "]" * 30, "nested too deeply"),
        ("a: &a [1]\n" + "b: &b [*a, *b]\n", "nested too deeply"),
        ("T: [" + "1," * 30_000 + "]", "holds more than 20000 entries"),
        ("a: &a 1\nb: &a 2\n", "not valid YAML (found duplicate anchor"),
        ("#" * 70_000, "larger than 0.064 MB"),
        (GOOD.replace("20", "1e400"), "line 8: '1e400' is not a finite number"),
        (GOOD.replace("20", ".inf"), "line 8: '.inf' is not a finite number"),
        (GOOD.replace("20", ".nan"), "line 8: '.nan' is not a finite number"),
        (GOOD.replace("20", "1" + "0" * 400), "line 8: "),
        (GOOD.replace("20", "1e300"), "line 8: '1e300' is not a finite number, or too large"),
        (GOOD.replace("20", "'20'"), "line 8: f_max: got text, expected a number or a list"),
        (GOOD.replace("20", "true"), "line 8: f_max: got true or false, expected a number or a list"),
        (GOOD.replace("f_max: 20\n", ""), "f_max: missing; give [N] of the thrusters"),
        (GOOD.replace("f_max", "fmax"), "line 8: unknown key 'fmax'; the keys are name, dof"),
        (GOOD.replace("20", "[20, 20, 20]"), "line 8: cross: f_max has shape (3,)"),
        (GOOD.replace("20", "[20, x, 20, 20]"), "line 8: f_max[1]: got text, expected a number"),
        (GOOD.replace("20", "-20"), "line 7: cross: f_min[0] = -10 exceeds f_max[0] = -20"),
        (GOOD.replace("-10", "0").replace("20", "0"), "line 8: cross: f_min and f_max are all 0"),
        (GOOD.replace("yaw", "yaaw"), "line 2: dof[2]: got 'yaaw', expected one of heave, pitch"),
        (GOOD.replace("yaw", "sway"), "line 2: cross: dof"),
        (GOOD.replace("surge, sway, yaw", ""), "line 3: T: has 3 rows; give 0"),
        (GOOD.replace("surge, sway, yaw", "surge, sway"), "line 3: T: has 3 rows; give 2, one a DOF"),
        (GOOD.replace("[0, 0, 1, 1]", "[0, 0, 1]"), "line 3: T: rows differ in length"),
        (GOOD.replace("[0, 0, 1, 1]", "[2, 2, 0, 0]"), "rank: T has rank 2 but 3 is asked for"),
        (GOOD + "rank: 2\n", "line 9: rank: T has rank 3 but 2"),
        (GOOD + "weights: [1, 1, 1, 0]\n", "line 9: weights: give numbers above 0"),
        (GOOD + "weights: [1, 1, 1, 1e-30]\n", "line 9: weights: 1e-30 is as good as 0 beside 1; give"),
        (GOOD + "volts: {12: [-1, 1], infinity: [-5, 5]}\n", "line 9: volts: 'infinity' is no voltage; give"),
        (GOOD + "volts: {12: [-1, 1], 1e9: [-5, 5]}\n", "line 9: volts: '1e9' is no voltage; give a number"),
        (GOOD + "volts: {nan: [-1, 1], 12: [-5, 5]}\n", "line 9: volts: 'nan' is no voltage; give a number"),
        (GOOD + "weights: [1, 1]\n", "line 9: weights: 2 numbers for 4 thrusters"),
        (GOOD + "H: [[1, 2], [3]]\n", "line 9: H: rows differ in length"),
        (GOOD + "H: [[1, 0], [0, 1]]\n", "line 9: cross: H has shape (2, 2)"),
        (GOOD + "weights: [1, 1, 1, 1]\nH: [[1]]\n", "line 10: weights and H both"),
        (GOOD + "slack_weights: [1, 1]\n", "line 9: cross: slack_weights has shape (2,)"),
        (GOOD + "weak: 0.6\n", "line 9: cross: weak is 0.6; give auto, or sigma / sigma_max from 0 (never)"),
        (GOOD + "weak: -1\n", "line 9: cross: weak is -1; give auto, or sigma / sigma_max from 0 (never)"),
        (GOOD + "weak: .nan\n", "line 9: '.nan' is not a finite number"),
        (GOOD + "weak: often\n", "line 9: weak: got 'often', expected one of auto"),
        (GOOD + "survey: {mm: -3}\n", "line 9: survey: mm is -3; give a tolerance of 0 or more"),
        (GOOD + "survey: {deg: .inf}\n", "line 9: '.inf' is not a finite number"),
        (GOOD + "survey: {cm: 1}\n", "line 9: survey: unknown key 'cm'; the keys are mm, deg, relative"),
        (GOOD + "survey: {mm: 3, relative: 0.1}\n", "line 9: survey: mm and deg are of poses, relative of"),
        (GOOD + "survey: {relative: 9}\n", "line 9: survey: every direction is weak: the thrusters push no"),
        (GOOD + "slack_weights: [1, 1, 0]\n", "line 9: cross: slack_weights must be positive"),
        (GOOD.replace("cross", '"a\\nb"'), "line 1: name: give 1 to 60 printable characters"),
        (GOOD.replace("cross", "''"), "line 1: name: give 1 to 60 printable characters"),
        (GOOD.replace("cross", "x" * 61), "line 1: name: give 1 to 60 printable characters"),
        (GOOD.replace("cross", "../../etc"), "line 1: name: give 1 to 60 printable characters without '/'"),
        (GOOD + '"a\\nb": 1\n', "line 9: unknown key 'a b'"),
        (GOOD + "k" * 500 + ": 1\n", "line 9: unknown key 'kkkk"),
        (GOOD + "frame: ned\n", "line 9: frame: got 'ned', expected one of flu, frd"),
        (GOOD + "planar: {alpha_deg: [1], d: [1, 2], phi_deg: [1]}\n", "equally long"),
        (GOOD + "thrusters: []\n", "line 9: thrusters: the list is empty"),
        (
            GOOD + "thrusters:\n  - {position: [0, 0, 0], direction: [1, 1, 0]}\n",
            "line 10: thrusters[0].direction has length 1.414; give a unit vector, as [0.7071, 0.7071, 0]",
        ),
        (
            GOOD + "thrusters:\n  - {position: [0, 0, 0]}\n",
            "line 10: thrusters[0]: key 'direction' is missing; give a unit vector, or 'azimuth'",
        ),
        (GOOD + "slew: {up: 30}\n", "line 9: slew: key 'down' is missing; the keys are up, down"),
        (
            GOOD + "thrusters:\n  - {position: [0, 0, 0], direction: [0, 0, 0]}\n",
            "line 10: thrusters[0].direction has length 0; give a unit vector, as [1, 0, 0]",
        ),
        (
            GOOD + "thrusters:\n  - {position: [0, 0], direction: [1, 0, 0]}\n",
            "line 10: thrusters[0].position: got 2 entries, expected 3; docs/your-vehicle.md shows the form",
        ),
        (
            GOOD + "priority: [[surge], [sway, pich]]\n",
            "line 9: priority[1][1]: got 'pich', expected one of heave, pitch",
        ),
        (
            GOOD + "volts:\n  12: [-1, 1]\n  16: [1]\n",
            "line 11: volts.16: got 1 entry, expected 2; docs/your-vehicle.md",
        ),
        (
            GOOD + "thrusters:\n  - {position: [0, 0, 0], direction: [1, 0, 0]}\n",
            "line 3: T: has 4 columns, but the poses are of 1 thrusters",
        ),
    ],
)
def test_a_bad_file_is_refused_in_one_line(file: Path, text: str | bytes, says: str) -> None:
    assert says in refusal(written(file, text))


def test_aliases_that_multiply_are_refused_before_they_are_expanded(file: Path) -> None:
    layers = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    layers += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 12)]
    assert "holds more than 20000 entries, aliases included" in refusal(written(file, "\n".join(layers)))


def test_a_folder_a_missing_file_and_a_locked_one_are_refused(tmp_path: Path) -> None:
    assert "is a directory" in refusal(tmp_path)
    assert "no such file" in refusal(tmp_path / "nowhere" / "x.yaml")
    locked = written(tmp_path / "locked.yaml", GOOD)
    locked.chmod(0)
    if not os.access(locked, os.R_OK):  # root reads everything
        assert "permission denied" in refusal(locked)


def test_a_device_without_end_is_refused() -> None:
    assert "larger than" in refusal(Path("/dev/zero"))


@pytest.mark.parametrize("name", ["", "no-such", "x" * 5000, "a\0b", "ukwial ", "../ukwial"])
def test_a_name_that_is_no_vehicle_and_no_file_is_refused(name: str) -> None:
    with pytest.raises(AllocError) as caught:
        load_vehicle(name)
    assert "\n" not in str(caught.value)
    if name == "no-such":
        assert isinstance(caught.value, UnknownName)
        assert "ukwial" in str(caught.value)


@given(st.text() | st.binary())
def test_any_text_is_a_vehicle_or_a_refusal(
    tmp_path_factory: pytest.TempPathFactory, text: str | bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass"))
    refusal(path)


numbers = st.floats() | st.integers() | st.text(max_size=3)
values = st.recursive(
    numbers | st.none() | st.booleans(), lambda inner: st.lists(inner, max_size=5), max_leaves=10
)


@given(key=st.sampled_from([line.split(":")[0] for line in GOOD.splitlines() if ": " in line]), value=values)
def test_any_value_of_any_key_is_a_vehicle_or_a_refusal(
    tmp_path_factory: pytest.TempPathFactory, key: str, value: object
) -> None:
    from ruamel.yaml import YAML

    path = tmp_path_factory.getbasetemp() / "value.yaml"
    data = YAML(typ="safe", pure=True).load(GOOD) | {key: value}
    with path.open("w", encoding="utf-8") as file:
        YAML(typ="safe", pure=True).dump(data, file)
    try:
        outcome: object = load_vehicle(path)
    except AllocError as refused:
        outcome = refused
    assert isinstance(outcome, Vehicle) or ("\n" not in str(outcome) and str(outcome).startswith(str(path)))


def test_a_vehicle_error_carries_the_key_at_fault(file: Path) -> None:
    with pytest.raises(VehicleError) as caught:
        load_vehicle(written(file, GOOD + "slack_weights: [1]\n"))
    assert caught.value.key == "slack_weights"
