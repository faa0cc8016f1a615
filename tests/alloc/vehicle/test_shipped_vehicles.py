"""Every shipped vehicle's T, worked out a second way from what its source prints."""

from contextvars import Context

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from alloc import build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.geometry import DOF


def wrench_of_a_push(position: FloatArray, direction: FloatArray) -> FloatArray:
    """Force and moment of 1 N, the moment by components rather than by numpy's cross product."""
    (x, y, z), (a, b, c) = position, direction
    return np.array([a, b, c, y * c - z * b, z * a - x * c, x * b - y * a])


def test_all_promised_vehicles_are_shipped() -> None:
    promised = {"ukwial", "bluerov2", "bluerov2-heavy", "nautilus", "subjugator8", "supply-vessel", "tiburon"}
    assert promised <= set(list_vehicles())


@pytest.mark.parametrize("name", list_vehicles())
def test_a_shipped_vehicle_names_its_source_and_reaches_every_dof_it_controls(name: str) -> None:
    vehicle = load_vehicle(name)
    assert vehicle.name == name
    assert vehicle.source
    assert vehicle.rank == vehicle.k
    assert (vehicle.f_min < 0).all()
    assert (vehicle.f_max > 0).all()


@pytest.mark.parametrize("name", list_vehicles())
def test_what_loads_and_prepares_leaves_no_context_variable_that_numpy_would_search_at_every_call(
    name: str,
) -> None:
    left = Context()
    left.run(lambda: build("nullspace", load_vehicle(name))(np.zeros(load_vehicle(name).k)))
    # numpy asks for its memory handler at each new array: beside another variable that takes 80 instructions.
    assert [variable.name for variable in left] == []


@pytest.mark.parametrize(
    ("name", "nullity"),
    [
        ("ukwial", 1),
        ("bluerov2", 1),
        ("bluerov2-heavy", 2),
        ("nautilus", 2),
        ("subjugator8", 2),
        ("supply-vessel", 3),
        ("tiburon", 2),
    ],
)
def test_a_shipped_vehicle_has_the_known_nullity(name: str, nullity: int) -> None:
    assert load_vehicle(name).nullity == nullity


def test_ukwial_is_equation_18_for_29_degrees() -> None:
    c, s, m = np.cos(np.radians(29)), np.sin(np.radians(29)), 0.332
    T = [[c, c, -c, -c], [s, -s, s, -s], [m, -m, -m, m]]
    assert pytest.approx(np.array(T), abs=1e-15) == load_vehicle("ukwial").T


def test_bluerov2_is_its_source_s_angles_turned_by_scipy() -> None:
    positions = [
        [0.1355, -0.1, -0.0725],
        [0.1355, 0.1, -0.0725],
        [-0.1475, -0.1, -0.0725],
        [-0.1475, 0.1, -0.0725],
        [0.0025, -0.1105, -0.005],
        [0.0025, 0.1105, -0.005],
    ]
    rpy = [[0, 0, 45], [0, 0, -45], [0, 0, 135], [0, 0, -135], [0, -90, 0], [0, -90, 0]]
    axes = np.array([1, 1, -1, -1, 1, -1])[:, None] * np.array([1.0, 0, 0])
    directions = Rotation.from_euler("xyz", rpy, degrees=True).apply(axes)
    columns = [wrench_of_a_push(np.array(p), d) for p, d in zip(positions, directions, strict=True)]
    full = np.array(columns).T
    vehicle = load_vehicle("bluerov2")
    rows = [DOF.index(axis) for axis in vehicle.dof]
    # The file has the cosines to ten decimals.
    assert pytest.approx(full[rows], abs=1e-10) == vehicle.T
    assert np.linalg.matrix_rank(full, tol=1e-9) == 5
    surge, _, heave, _, pitch, _ = full
    assert vehicle.frame == "flu"
    assert pitch == pytest.approx(-0.0725 * surge - 0.0025 * heave, abs=1e-12)


def test_nautilus_has_the_arms_about_its_centre_of_mass() -> None:
    # The source's vertical distance from thrusters to the centre of mass: 0.021736 - 0.01 m.
    T = load_vehicle("nautilus").T
    arm = 0.011736 * 0.70711
    expected = [
        [0.70711, 0, 0, -0.70711, -0.70711, 0, 0, 0.70711],
        [-0.70711, 0, 0, -0.70711, 0.70711, 0, 0, 0.70711],
        [0, 1, 1, 0, 0, 1, 1, 0],
        [arm, 0.313022, 0.313022, arm, -arm, -0.313022, -0.313022, -arm],
        [arm, -0.140095, 0.163904, -arm, -arm, 0.163904, -0.140095, arm],
        np.array([-1, 0, 0, 1, -1, 0, 0, 1]) * 0.70711 * (0.413892 + 0.313022),
    ]
    assert np.array(expected) == pytest.approx(T, abs=1e-15)


def test_subjugator8_is_in_its_source_s_frame() -> None:
    T = load_vehicle("subjugator8").T
    expected = [
        [-0.866, 0, -0.866, 0, -0.866, 0, -0.866, 0],
        [0.5, 0, -0.5, 0, -0.5, 0, 0.5, 0],
        [0, 1, 0, 1, 0, 1, 0, 1],
        [0, 0.169, 0, -0.169, 0, 0.169, 0, -0.169],
        [0, -0.1583, 0, -0.1583, 0, 0.1583, 0, 0.1583],
        np.array([1, 0, -1, 0, 1, 0, -1, 0]) * (0.2678 * 0.5 + 0.2795 * 0.866),
    ]
    assert load_vehicle("subjugator8").frame == "flu"
    assert np.array(expected) == pytest.approx(T, abs=1e-15)


def test_the_supply_vessel_s_limits_are_k_times_the_highest_speed_squared() -> None:
    vehicle = load_vehicle("supply-vessel")
    thrust = [3.2 * 250**2] * 4 + [31.2 * 160**2] * 2
    assert vehicle.f_max == pytest.approx(np.array(thrust), rel=1e-15)
    assert vehicle.f_min == pytest.approx(-np.array(thrust), rel=1e-15)


def test_bluerov2_heavy_is_two_blocks_that_share_nothing() -> None:
    T = load_vehicle("bluerov2-heavy").T
    horizontal, vertical = [0, 1, 5], [2, 3, 4]
    assert not T[np.ix_(horizontal, range(4, 8))].any()
    assert not T[np.ix_(vertical, range(4))].any()
