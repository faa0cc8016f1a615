"""Remarks of ``check`` on a T printed to a few digits, and on one with a digit in another's place."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import yaml

from alloc import list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.lint.check import check_vehicle
from alloc.lint.geometry import decimals, nearly_dependent
from alloc.lint.report import Finding
from alloc.vehicle.geometry import DOF
from bench.demands.generated import FAMILIES, three_planes
from tests.places import ROOT

SAYS = "looks like a symmetric vehicle printed to"


def symmetric() -> FloatArray:
    """T of eight thrusters, each the mirror image of others about three planes, about a point off them.

    About a point on them equal numbers are printed alike, and what depends on each other goes on doing so.
    """
    places, pushes = three_planes(np.random.default_rng(2))
    pushes = pushes / np.linalg.norm(pushes, axis=1, keepdims=True)
    return np.vstack([pushes.T, np.cross(places - [0.0137, 0.0071, 0.0319], pushes).T])


def found(folder: Path, says: str, dof: Sequence[str] = DOF, **geometry: object) -> list[Finding]:
    file = folder / "printed.yaml"
    file.write_text(
        yaml.safe_dump({"name": "printed", "dof": [*dof], **geometry, "f_min": -40.0, "f_max": 60.0})
    )
    return [finding for finding in check_vehicle(str(file)).findings if says in finding.message]


def remarks(T: FloatArray, folder: Path) -> list[str]:
    return [finding.message for finding in found(folder, SAYS, T=T.tolist())]


MIRRORED = np.array(
    [
        [0.86602540378, 0.86602540378, 0.86602540378, 0.86602540378, 0, 0, 0, 0],
        [0.5, -0.5, -0.5, 0.5, 0, 0, 0, 0],
        [0, 0, 0, 0, 1, 1, 1, 1],
        [0, 0, 0, 0, -0.14922, 0.14922, -0.14922, 0.14922],
        [0, 0, 0, 0, -0.230185, -0.230185, 0.230185, 0.230185],
        [0.2695308, -0.2695308, 0.337687697, -0.337687697, 0, 0, 0, 0],
    ]
)
"""T of a vehicle of which port is the mirror image of starboard."""
ODD = "every other entry has its image"


def test_two_digits_exchanged_in_one_entry_are_named_with_what_its_twins_have(tmp_path: Path) -> None:
    T = MIRRORED.copy()
    T[4, 7] = 0.231085
    (remark,) = found(tmp_path, ODD, T=T.tolist())
    assert (remark.level, remark.key) == ("warning", "T")
    assert remark.message.startswith(
        "pitch of thruster 7 is 0.231085; by its twins (thruster 4, thruster 5, thruster 6) it would be"
        " 0.230185, two digits exchanged"
    )


@pytest.mark.parametrize("seed", range(6))
def test_any_slip_in_a_mirrored_table_is_named_with_the_entry_that_it_was(seed: int, tmp_path: Path) -> None:
    """The second or third decimal of some entry is one more or one less."""
    rng = np.random.default_rng(seed)
    places, pushes = three_planes(rng)
    pushes = pushes / np.linalg.norm(pushes, axis=1, keepdims=True)
    right = np.vstack([pushes.T, np.cross(places, pushes).T]).round(6)
    T, (row, i) = right.copy(), rng.integers((6, 8))
    T[row, i] += rng.choice([-1, 1]) * 10.0 ** -int(rng.integers(2, 4))
    (remark,) = found(tmp_path, ODD, T=T.round(6).tolist())
    assert remark.message.startswith(f"{DOF[row]} of thruster {i} is {T[row, i]:.6g}; by its twins (")
    assert f"it would be {right[row, i]:.6g}" in remark.message


def test_a_slip_in_a_position_is_named_where_the_others_are_mirrored_about_the_center_of_mass(
    tmp_path: Path,
) -> None:
    corners = np.array(
        [[0.1563, 0.1112, 0.0], [0.1563, -0.1112, 0.0], [-0.12, 0.2184, 0.0], [-0.12, -0.2184, 0.0]]
    )
    places = corners + np.array([0.0137, 0.0, 0.0319])
    places[3, 1] = -0.2148
    thrusters = [{"position": place, "direction": [0.0, 0.0, 1.0]} for place in places.tolist()]
    (remark,) = found(
        tmp_path,
        ODD,
        ("heave", "roll", "pitch"),
        thrusters=thrusters,
        center_of_mass=[0.0137, 0.0, 0.0319],
    )
    assert (remark.level, remark.key) == ("warning", "thrusters[3]")
    assert remark.message.startswith(
        "y of the position of thruster 3 is -0.2148; by its twins (thruster 2) it would be -0.2184"
    )


def test_a_vehicle_as_it_is_flown_has_no_odd_entry() -> None:
    files = [*list_vehicles(), *(ROOT / "docs/vehicles").glob("*.yaml")]
    files += sorted((Path(__file__).parent / "data" / "published").glob("*.yaml"))
    assert len(files) > 19
    assert not [str(file) for file in files for each in check_vehicle(file).findings if ODD in each.message]


@pytest.mark.parametrize("seed", range(8))
def test_a_vehicle_that_is_meant_to_be_uneven_is_not_warned_of(seed: int, tmp_path: Path) -> None:
    """Thrusters anywhere; and a mirrored vehicle of which one thruster was moved, or is missing."""
    rng = np.random.default_rng(seed)
    assert found(tmp_path, ODD, T=rng.normal(size=(6, 7)).round(int(rng.integers(1, 8))).tolist()) == []
    places, pushes = FAMILIES[seed % 3](rng)
    places, pushes = places.round(3), pushes / np.linalg.norm(pushes, axis=1, keepdims=True)
    moved, turned = places.copy(), pushes.copy()
    moved[0] += rng.uniform(0.05, 0.2, 3).round(2)
    turned[0] = turned[0][[1, 2, 0]]
    for place, push in ((moved, turned), (moved, pushes), (moved[1:], pushes[1:])):
        T = np.vstack([push.T, np.cross(place, push).T])
        assert found(tmp_path, ODD, T=T.tolist()) == []


@pytest.mark.parametrize("digits", [4, 6, 8])
def test_a_symmetric_matrix_that_was_printed_is_seen(digits: int, tmp_path: Path) -> None:
    (said,) = remarks(symmetric().round(digits), tmp_path)
    assert f"{SAYS} {digits} decimals" in said
    assert said.endswith("poses ('thrusters') give it exactly")


def test_nothing_is_said_of_all_digits_nor_of_a_vehicle_that_is_not_symmetric(tmp_path: Path) -> None:
    assert remarks(symmetric(), tmp_path) == []
    generic = np.random.default_rng(2).normal(size=(6, 8))
    assert remarks(generic.round(6), tmp_path) == []


def test_sets_that_a_printed_digit_decides_are_those_that_lose_rank_in_truth() -> None:
    """With all digits these sets have a singular value of rounding, so both count the same."""
    T, vehicle = symmetric(), load_vehicle("bluerov2-heavy")
    unit = T / np.linalg.norm(T, axis=1)[:, None]
    truth = sum(np.linalg.matrix_rank(unit[:, list(each)], 1e-9) < 6 for each in combinations(range(8), 6))
    printed = replace(vehicle, T=T.round(6))
    near, count = nearly_dependent(printed, 6)
    assert count == 28
    exact = sum(
        np.linalg.matrix_rank(printed.T[:, list(each)], 1e-13) < 6 for each in combinations(range(8), 6)
    )
    assert near + exact == truth
    assert near > 0


@pytest.mark.parametrize(("digits", "found"), [(3, None), (4, 4), (7, 7), (12, 12), (14, None)])
def test_decimals_are_those_that_were_printed(digits: int, found: int | None) -> None:
    assert decimals(np.random.default_rng(3).normal(size=(6, 8)).round(digits)) == found


def test_a_thruster_that_moves_no_controlled_axis_has_no_digits(tmp_path: Path) -> None:
    """A column of zeros of a printed T ended in a traceback of the linear algebra."""
    file = tmp_path / "planar.yaml"
    file.write_text(
        "name: planar\ndof: [surge, yaw]\nf_min: -40\nf_max: 40\nT: [[1, 1, 0], [0.7071, -0.7071, 0]]\n"
    )
    said = [finding.message for finding in check_vehicle(str(file)).findings]
    assert any("moves no controlled DOF" in each for each in said)
