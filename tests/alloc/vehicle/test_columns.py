"""Columns of T that a thruster can make, where force . moment is 0, and those that none can."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import list_vehicles, load_vehicle
from alloc.errors import VehicleError
from alloc.lint.check import check_vehicle
from alloc.vehicle.file import called, find_file, matrices, poses, read_document, suspects
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF, alike, along_thrust, pose_matrix, possible, refusals

TIBURON = Path(__file__).parent / "data" / "tiburon.yaml"
"""The matrix of a vehicle that has swum, with its authors' doubt about the signs of T6 to T8."""


def thrusters(seed: int, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions [m], directions and propellers' moments [m] of n thrusters."""
    rng = np.random.default_rng(seed)
    directions = rng.standard_normal((n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return rng.uniform(-1, 1, (n, 3)), directions, rng.uniform(-0.1, 0.1, n)


@given(st.integers(0, 10**6), st.integers(2, 4))
def test_any_thrust_along_a_line_is_possible_also_once_printed_and_in_either_frame(
    seed: int, digits: int
) -> None:
    positions, directions, moments = thrusters(seed, 5)
    for m in (np.zeros(5), moments):
        T = pose_matrix(positions, directions, np.full(3, 0.1), m).round(digits)
        for rows in (T, turned(T, DOF)):
            assert possible(rows, DOF, m).all()
            found = along_thrust(rows, DOF)
            assert (np.abs(found.moment - m) <= found.rounding).all()


@given(st.integers(0, 10**6))
def test_a_propeller_s_own_moment_is_found_to_the_last_digit_of_a_matrix_that_is_not_rounded(
    seed: int,
) -> None:
    positions, directions, moments = thrusters(seed, 4)
    T = pose_matrix(positions, directions, reaction_torque=moments)
    np.testing.assert_allclose(along_thrust(T, DOF).moment, moments, rtol=0, atol=1e-14)


def test_rows_that_a_matrix_leaves_out_are_given_the_benefit_of_the_doubt() -> None:
    """Without pitch a column with sway may have any pitch that makes it possible; without sway it may not."""
    T = np.array([[0.6, 1.0], [0.8, 0], [0, 0], [0.25, 0.25], [0.1, 0.1]])
    moment = along_thrust(T, ("surge", "sway", "heave", "roll", "yaw")).moment
    assert np.isnan(moment[0])
    assert moment[1] == pytest.approx(0.25)
    both = T[[0, 2, 3, 4]]  # sway and pitch are left out, and so is their product
    assert np.isnan(along_thrust(both, ("surge", "heave", "roll", "yaw")).moment).all()


def test_the_flown_matrix_is_refused_with_names_numbers_and_suspects() -> None:
    """Red before: 0 errors. Thrusters 5 to 8 differ in nothing but signs and one arm each."""
    report = check_vehicle(TIBURON)
    errors = [finding.message for finding in report.findings if finding.level == "error"]
    assert [error.split()[0] for error in errors] == ["T6", "T7", "T8"]
    assert "roll 0.0140, pitch -0.0140, yaw 0.0346): force · moment" in errors[0]
    assert "force · moment = -0.0198 m" in errors[0]
    assert "pitch is the suspect: with 0.0140 it would go with T5, turned by 180 degrees about z" in errors[0]
    assert "roll is the suspect: with 0.0140" in errors[1]
    assert "roll is the suspect: with -0.0140 it would go with T5" in errors[2]
    with pytest.raises(VehicleError, match=r"T: T6 \(surge -0\.707"):
        load_vehicle(TIBURON)


def test_a_column_under_suspicion_is_taken_as_published_and_check_goes_on_saying_so(tmp_path: Path) -> None:
    file = tmp_path / "published.yaml"
    for told in ("[T6, 6, T8]", "[5, 6, 7]"):
        file.write_text(f"{TIBURON.read_text()}suspect: {told}\n")
        assert load_vehicle(file).n == 8
        found = [(f.level, f.message) for f in check_vehicle(file).findings if "force · moment" in f.message]
        assert [level for level, _ in found] == ["warning"] * 3
        assert found[0][1].startswith("taken as published: T6 (surge -0.707, ")
    file.write_text(f"{TIBURON.read_text()}suspect: [T5, T6, T7]\n")
    with pytest.raises(VehicleError, match=r"T: T8 .* write 'suspect: \[7\]'"):
        load_vehicle(file)
    assert "T5 is a thrust along a line; leave it out" in str(check_vehicle(file).findings)
    for told, says in (("[8]", "there is no thruster 8; count from 0 to 7"), ("[T9]", "no thruster 'T9'")):
        file.write_text(f"{TIBURON.read_text()}suspect: {told}\n")
        with pytest.raises(VehicleError, match=f"suspect: {says}"):
            load_vehicle(file)


def test_mending_the_suspects_makes_it_a_vehicle(tmp_path: Path) -> None:
    text = TIBURON.read_text()
    roll = "[0.1700, -0.1200, 0.1200, -0.1200, -0.0140, 0.0140, -0.0140, 0.0140]"
    pitch = "[-0.1200, -0.1200, 0.1500, 0.1500, -0.0140, -0.0140, -0.0140, -0.0140]"
    assert roll in text
    assert pitch in text
    file = tmp_path / "mended.yaml"
    file.write_text(
        text.replace(roll, roll.replace("-0.0140, 0.0140]", "0.0140, -0.0140]")).replace(
            pitch, pitch.replace("-0.0140, -0.0140, -0.0140, -0.0140]", "-0.0140, 0.0140, -0.0140, -0.0140]")
        )
    )
    assert load_vehicle(file).rank == 6


def test_reaction_torque_explains_what_no_line_does(tmp_path: Path) -> None:
    file = tmp_path / "told.yaml"
    file.write_text(f"{TIBURON.read_text()}reaction_torque: [0, 0, 0, 0, 0, -0.0198, -0.0198, 0.0198]\n")
    assert load_vehicle(file).n == 8
    file.write_text(f"{TIBURON.read_text()}reaction_torque: [0, 0, 0, 0, 0, 0.0198, -0.0198, 0.0198]\n")
    with pytest.raises(VehicleError, match="T6"):
        load_vehicle(file)
    file.write_text(f"{TIBURON.read_text()}reaction_torque: [0.02]\n")
    with pytest.raises(VehicleError, match="reaction_torque: 1 numbers for 8 thrusters; give one each"):
        load_vehicle(file)


def test_the_moment_of_a_propeller_is_a_part_of_what_poses_make(tmp_path: Path) -> None:
    """A rotor at (0.3, 0, 0) that pushes up (-z in frd), with 0.05 m of its own moment along its thrust."""
    file = tmp_path / "rotor.yaml"
    file.write_text(
        "name: rotor\ndof: [heave, pitch, yaw]\nrank: 1\n"
        "thrusters: [{position: [0.3, 0, 0], direction: [0, 0, -1]}]\n"
        "reaction_torque: 0.05\nf_min: 0\nf_max: 9\n"
    )
    np.testing.assert_allclose(load_vehicle(file).T, [[-1], [0.3], [-0.05]])


def test_propellers_of_one_kind_are_warned_about_and_not_refused(tmp_path: Path) -> None:
    positions, directions, _ = thrusters(3, 7)
    moments = 0.06 * np.array([1, -1, 1, -1, 1, 1, -1])
    T = pose_matrix(positions, directions, reaction_torque=moments).round(4)
    assert alike(T, DOF) == pytest.approx(0.06, abs=1e-3)
    file = tmp_path / "alike.yaml"
    rows = "".join(f"  - {row}\n" for row in T.tolist())
    file.write_text(f"name: alike\ndof: [{', '.join(DOF)}]\nT:\n{rows}f_min: -9\nf_max: 9\n")
    warnings = [f.message for f in check_vehicle(file).findings if f.level == "warning"]
    assert any("0.06 m along its own thrust" in warning for warning in warnings)
    assert load_vehicle(file).n == 7


def test_what_no_propeller_is_long_enough_for_is_no_moment_of_its_own() -> None:
    """A T with one thruster a row has arms there, of a third of a metre: it was taken without a word."""
    positions, directions, _ = thrusters(3, 7)
    moments = 0.33 * np.array([1, -1, 1, -1, 1, 1, -1])
    T = pose_matrix(positions, directions, reaction_torque=moments)
    assert alike(T, DOF) == 0
    assert len(refusals(T, DOF, np.zeros(7), [f"T{i}" for i in range(7)])) == 7


@pytest.mark.parametrize("name", list_vehicles())
def test_a_wrong_sign_in_any_arm_of_a_shipped_vehicle_is_found_where_it_breaks_the_line(name: str) -> None:
    keys = read_document(find_file(name)).keys
    T, _ = matrices(keys)
    names, none = called(keys, T.shape[1]), np.zeros(T.shape[1])
    known = refusals(T, keys.dof, none, names)
    assert known.keys() == suspects(keys, len(names))
    before = along_thrust(T, keys.dof)
    for i in range(T.shape[1]):
        for row in np.flatnonzero(np.abs(T[:, i]) > 0.01).tolist():
            wrong = T.copy()
            wrong[row, i] *= -1
            broken = abs(along_thrust(wrong, keys.dof).moment[i]) > before.rounding[i]
            found = refusals(wrong, keys.dof, none, names)
            assert (i in found) == broken
            assert found.keys() - {i} == known.keys() - {i}
            if broken:
                assert found[i].startswith(f"{names[i]} (")


def test_only_columns_of_a_line_have_a_place_where_the_thruster_stands() -> None:
    keys = read_document(TIBURON).keys
    T, _ = matrices(keys)
    mounting = poses(keys, T)
    assert mounting.stands.tolist() == [True] * 5 + [False] * 3
    made = pose_matrix(mounting.positions, mounting.directions)
    np.testing.assert_allclose(made[:, :5], T[:, :5], atol=1e-12)


def test_numbers_are_shown_with_the_digits_of_the_file() -> None:
    refused = refusals(
        np.array([[1.0, 0.0], [0, 1], [0, 0], [0.0201, 0], [0, 0], [0, 0.3]]), DOF, np.zeros(2), ["a", "b"]
    )
    assert refused.keys() == {0}
    assert re.match(r"a \(surge 1, roll 0\.0201\): force · moment = 0\.0201 m, expected 0", refused[0])
