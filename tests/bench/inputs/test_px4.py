"""PX4 parameters made into vehicle files."""

from pathlib import Path

import numpy as np
import pytest

from bench.inputs.formats.px4 import UNUSED
from bench.inputs.imported import ImportOptions
from tests.foreign_vehicles import imported, vehicle_of
from tests.readers import refused

HEXA = """\
#!/bin/sh
# CA_ROTOR9_PX 5 in a comment is no parameter
param set-default CA_ROTOR_COUNT 6
param set-default CA_ROTOR0_PY 0.5
param set-default CA_ROTOR0_KM -0.05
param set-default CA_ROTOR1_PY -0.5
param set-default CA_ROTOR2_PX 0.43
param set-default CA_ROTOR2_PY -0.25
param set-default CA_ROTOR2_KM -0.05
param set-default CA_ROTOR3_PX -0.43
param set-default CA_ROTOR3_PY 0.25
param set-default CA_ROTOR4_PX 0.43
param set-default CA_ROTOR4_PY 0.25
param set-default CA_ROTOR5_PX -0.43
param set-default CA_ROTOR5_PY -0.25
param set-default CA_ROTOR5_KM -0.05
"""


def test_unset_parameters_take_the_defaults_of_px4(tmp_path: Path) -> None:
    """Roll, pitch, yaw and thrust of PX4's hexarotor x, as PX4 works them out."""
    keys = imported(tmp_path, HEXA)
    assert keys.dof == ["heave", "roll", "pitch", "yaw"]
    expected = [
        [-1, -1, -1, -1, -1, -1],
        [-0.5, 0.5, 0.25, -0.25, -0.25, 0.25],
        [0, 0, 0.43, -0.43, 0.43, -0.43],
        [-0.05, 0.05, -0.05, 0.05, 0.05, -0.05],
    ]
    vehicle = vehicle_of(keys, tmp_path)
    np.testing.assert_allclose(vehicle.T, expected, atol=1e-15)
    assert (vehicle.f_min.tolist(), vehicle.f_max.tolist()) == ([0] * 6, [1] * 6)
    assert any("PX4's default" in note for note in keys.notes)
    assert any("shares of full throttle, no newtons" in note for note in keys.notes)
    told = imported(tmp_path, HEXA, ImportOptions(f_min=-40.0, f_max=50.0))
    assert not any("full throttle" in note or "one way only" in note for note in told.notes)


def test_of_a_value_changed_in_flight_the_last_one_counts(tmp_path: Path) -> None:
    """As ``ulog_params`` of pyulog 1.3.0 writes it: the value at the start, then each later one."""
    text = "".join(f"CA_ROTOR{i}_PX,0.1,{i}\nCA_ROTOR{i}_CT,6.5,7.0,7.5\n" for i in range(3))
    keys = imported(tmp_path, text, name="ulog.txt")
    assert [thruster.position[0] for thruster in keys.thrusters or []] == [0, 1, 2]
    assert keys.f_max == 7.5
    assert any("CA_ROTOR2_CT, changed in flight, the last value counts" in note for note in keys.notes)


def test_a_comment_behind_a_parameter_sets_nothing(tmp_path: Path) -> None:
    """The older value in it was taken."""
    whole = vehicle_of(imported(tmp_path, HEXA), tmp_path)
    line = "param set-default CA_ROTOR4_PX 0.43"
    noted = vehicle_of(imported(tmp_path, HEXA.replace(line, f"{line} # was CA_ROTOR4_PX 0.35")), tmp_path)
    np.testing.assert_array_equal(noted.T, whole.T)


def test_a_params_file_gives_axes_coefficients_and_reversible_rotors(tmp_path: Path) -> None:
    rotors = {0: (1, 0, 0, 0.3), 1: (1, 0, 0, -0.3), 2: (0, 3, 0, 0.0)}  # the last axis has length 3
    lines = [
        "# Vehicle-Id Component-Id Name Value Type",
        "1\t1\tCA_ROTOR_COUNT\t3\t6",
        "1\t1\tCA_R_REV\t3\t6",
    ]
    for i, (x, y, z, arm) in rotors.items():
        values = {"AX": x, "AY": y, "AZ": z, "PY": arm, "KM": 0, "CT": 10 + i}
        lines += [f"1\t1\tCA_ROTOR{i}_{key}\t{value}\t9" for key, value in values.items()]
    vehicle = vehicle_of(imported(tmp_path, "\n".join(lines)), tmp_path)
    assert vehicle.dof == ("surge", "sway", "yaw")
    np.testing.assert_array_equal(vehicle.T, [[1, 1, 0], [0, 0, 1], [-0.3, 0.3, 0]])
    assert vehicle.f_max.tolist() == [10, 11, 12]
    assert vehicle.f_min.tolist() == [-10, -11, 0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (HEXA.replace("COUNT 6", "COUNT 99"), "CA_ROTOR_COUNT: got 99, expected 1 to 32"),
        (HEXA.replace("0.43", "far"), "CA_ROTOR2_PX: got 'far', expected a number"),
        (HEXA.replace("0.43", "1e400"), "line 7: CA_ROTOR2_PX: got '1e400', expected a number up to 1e+"),
        (HEXA + "param set CA_ROTOR0_AZ 0\n", "CA_ROTOR0_AX, AY, AZ: got 0, 0, 0, expected an axis"),
        (
            HEXA.replace("ROTOR1_", "ROTOR6_"),
            "nothing is set of CA_ROTOR1, one of 6 rotors; count them from 0",
        ),
        ("CA_ROTOR1_PY 1\nCA_ROTOR2_PY -1\n", "nothing is set of CA_ROTOR0, one of 2 rotors"),
        (HEXA.replace("COUNT 6", "COUNT 5"), "CA_ROTOR5_PX is set, but CA_ROTOR_COUNT is 5; delete it"),
        (
            HEXA + "CA_ROTOR2_CT -40\n",
            "CA_ROTOR2_CT: got -40, expected above 0, along its axis; turn AX, AY, AZ about",
        ),
    ],
)
def test_parameters_that_make_no_rotors_are_refused(tmp_path: Path, text: str, says: str) -> None:
    assert says in refused(lambda: imported(tmp_path, text), tmp_path / "theirs.yaml")


def test_rotors_beyond_the_count_that_have_the_defaults_are_none(tmp_path: Path) -> None:
    """As a file of all parameters has them."""
    unused = "".join(f"CA_ROTOR6_{key} {np.float32(value):.18f}\n" for key, value in UNUSED.items())
    assert vehicle_of(imported(tmp_path, HEXA + unused), tmp_path).n == 6
