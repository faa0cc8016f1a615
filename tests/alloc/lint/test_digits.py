"""What ``check`` says of a T that was printed to a few digits."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import yaml

from alloc import load_vehicle
from alloc.allocation import FloatArray
from alloc.lint.check import check_vehicle
from alloc.lint.digits import decimals, nearly_dependent
from bench.demands.near_degenerate import three_planes

SAYS = "looks like a symmetric vehicle printed to"


def symmetric() -> FloatArray:
    """T of eight thrusters, each the mirror image of others about three planes, about a point off them.

    About a point on them equal numbers are printed alike, and what depends on each other goes on doing so.
    """
    places, pushes = three_planes(np.random.default_rng(2))
    pushes = pushes / np.linalg.norm(pushes, axis=1, keepdims=True)
    return np.vstack([pushes.T, np.cross(places - [0.0137, 0.0071, 0.0319], pushes).T])


def remarks(T: FloatArray, folder: Path) -> list[str]:
    file = folder / "printed.yaml"
    dof = ["surge", "sway", "heave", "roll", "pitch", "yaw"]
    file.write_text(
        yaml.safe_dump({"name": "printed", "dof": dof, "T": T.tolist(), "f_min": -40.0, "f_max": 60.0})
    )
    return [finding.message for finding in check_vehicle(str(file)).findings if SAYS in finding.message]


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
