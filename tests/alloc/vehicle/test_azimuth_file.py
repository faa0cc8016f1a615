"""Azimuth thrusters of a vehicle file: their polygons, components and names, and what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError, Vehicle, build, load_vehicle
from alloc.errors import VehicleError
from alloc.vehicle.azimuth import Azimuth, polygon_corners
from alloc.vehicle.azimuth_file import free_arcs
from alloc.vehicle.limits import VoltageTable
from tests.azimuths import FERRY, corners_lp, demands_around

MIXED = """\
name: boat
dof: [surge, sway, yaw]
thrusters:
  - {position: [2, 0, 0], direction: [0, 1, 0], name: tunnel}
  - {position: [-2, 0, 0], azimuth: {max: 80, sector_deg: [-90, 90], sides: 8}, name: pod}
  - {position: [-2, 1, 0], direction: [1, 0, 0]}
f_min: -30
f_max: [30, 40]
weights: [1, 2, 3]
"""


PENTAGRAM = [[np.cos(angle), np.sin(angle)] for angle in np.radians([0, 144, 288, 72, 216])]


def load(text: str, folder: Path) -> Vehicle:
    file = folder / "boat.yaml"
    file.write_text(text)
    return load_vehicle(file)


def test_a_ferry_has_two_components_for_each_thruster(tmp_path: Path) -> None:
    vehicle = load(FERRY, tmp_path)
    assert vehicle.actuators == ((0, 1), (2, 3))
    assert vehicle.T.tolist() == [[1, 0, 1, 0], [0, 1, 0, 1], [0, 1.8, 0, -1.8]]
    assert vehicle.f_max.tolist() == [100.0] * 4
    assert vehicle.half_planes is not None
    assert vehicle.half_planes.A.shape == (32, 4)
    assert vehicle.half_planes.reach == pytest.approx(100 * np.cos(np.pi / 16))
    assert vehicle.with_fault("stern").TP[:, 2:].tolist() == [[0, 0]] * 3
    assert vehicle.with_fault("stern").faults == ((1, 0.0),)


def test_fixed_thrusters_stand_beside_them_in_the_order_of_the_file(tmp_path: Path) -> None:
    vehicle = load(MIXED, tmp_path)
    assert vehicle.actuators == ((0,), (1, 2), (3,))
    assert vehicle.names == ("tunnel", "pod", "")
    assert vehicle.f_min.tolist() == [-30.0, 0.0, -80.0, -30.0]
    assert vehicle.f_max.tolist() == [30.0, 80.0, 80.0, 40.0]
    assert np.diag(vehicle.H).tolist() == [1.0, 2.0, 2.0, 3.0]
    assert vehicle.T[:, 1:3].T.tolist() == [[1.0, 0.0, 0.0], [0.0, 1.0, -2.0]]
    assert vehicle.with_fault(2).faults == ((2, 0.0),)


@pytest.mark.parametrize("sides", [3, 4, 7, 16])
@pytest.mark.parametrize("sector", [(-180.0, 180.0), (-90.0, 90.0), (10.0, 70.0), (100.0, 280.0)])
def test_a_polygon_lies_in_its_sector_and_loses_what_the_sides_say(
    sector: tuple[float, float], sides: int
) -> None:
    corners = polygon_corners(50.0, sector, sides)
    sizes = np.linalg.norm(corners, axis=1)
    assert np.isin(sizes.round(9), [0.0, 50.0]).all()
    angles = np.degrees(np.arctan2(corners[:, 1], corners[:, 0]))[sizes > 0.0]
    start, end = sector
    assert ((angles - start + 1e-9) % 360.0 <= end - start + 2e-9).all()
    along = np.linspace(np.radians(start), np.radians(end), 999)
    wanted = np.column_stack([np.cos(along), np.sin(along)])
    outward = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([outward[:, 1], -outward[:, 0]]) / np.linalg.norm(outward, axis=1)[:, None]
    reach = (normals * corners).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        along_ray = np.where(wanted @ normals.T > 1e-9, reach / (wanted @ normals.T), np.inf).min(axis=1)
    assert along_ray.min() >= 50.0 * np.cos(np.pi / sides) - 1e-6


def test_zones_are_cut_out_of_a_sector_whatever_turn_they_are_in() -> None:
    assert free_arcs((-180.0, 180.0), [(170.0, 190.0)]) == [(-170.0, 170.0)]
    assert free_arcs((-180.0, 180.0), [(-10.0, 10.0)]) == [(10.0, 350.0)] or free_arcs(
        (-180.0, 180.0), [(-10.0, 10.0)]
    ) == [(-350.0, -10.0)]
    assert free_arcs((-90.0, 90.0), [(60.0, 100.0), (-400.0, -380.0)]) == [(-90.0, -40.0), (-20.0, 60.0)]
    assert free_arcs((0.0, 90.0), [(-10.0, 45.0), (40.0, 100.0)]) == []


def test_a_zone_at_the_end_leaves_one_sector(tmp_path: Path) -> None:
    zoned = "azimuth: {max: 100, sector_deg: [-90, 120], forbidden_deg: [[60, 130]]}"
    vehicle = load(FERRY.replace("azimuth: {max: 100}", zoned), tmp_path)
    assert vehicle.azimuths[0].corners == pytest.approx(polygon_corners(100.0, (-90.0, 60.0), 16))


@pytest.mark.parametrize(
    ("azimuth", "said"),
    [
        ("{max: 100, sector_deg: [-200, 200]}", "azimuth.sector_deg: spans 400 degrees; give at most 360"),
        (
            "{max: 100, sector_deg: [0, 6.28]}",
            "azimuth.sector_deg: [0.0, 6.28] look like radians; give degrees",
        ),
        (
            "{max: 100, sector_deg: [90, -90]}",
            "azimuth.sector_deg: is [90.0, -90.0]; give [from, to] in degrees",
        ),
        (
            "{max: 100, forbidden_deg: [[2.97, 3.32]]}",
            "azimuth.forbidden_deg: [2.97, 3.32] look like radians",
        ),
        ("{max: 100, forbidden_deg: [[9, 5]]}", "azimuth.forbidden_deg: has [9.0, 5.0]; give [from, to]"),
        (
            "{max: 100, sector_deg: [0, 90], forbidden_deg: [[-10, 50], [40, 95]]}",
            "azimuth.forbidden_deg: leaves nothing of the sector; give smaller zones",
        ),
        ("{max: 100, min: 120}", "azimuth.min: is 120; give 0, or a force up to max = 100 [N]"),
        ("{max: 0}", "azimuth.max: is 0; give the largest force, above 0 [N]"),
        ("{max: 100, sides: 2}", "azimuth.sides: is 2; give 3 to 64 sides"),
        ("{max: 100, sides: 65}", "azimuth.sides: is 65; give 3 to 64 sides"),
        ("{max: 100, sides: 4.5}", "azimuth.sides: got a number, expected a whole number"),
        ("{max: 100, radius: 5}", "azimuth: unknown key 'radius'; the keys are max, min, sector_deg"),
        ("{min: 0}", "azimuth: key 'max' is missing"),
        ("{max: 100}, direction: [1, 0, 0]", "has direction and azimuth; keep one of them"),
    ],
)
def test_an_azimuth_that_is_none_is_refused_in_one_line(azimuth: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(VehicleError) as refused:
        load(FERRY.replace("{max: 100}", azimuth, 1), tmp_path)
    assert said in str(refused.value)
    assert str(refused.value).startswith(f"{tmp_path / 'boat.yaml'}, line 4: thrusters[0]")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("f_min: -10", "line 6: f_min: no fixed thruster is there to have it; leave it out"),
        (
            "T: [[1, 0], [0, 1], [0, 0]]",
            "line 6: T: not supported yet beside azimuth thrusters; leave it out",
        ),
        ("volts: {12: [-1, 1], 14: [-2, 2]}", "line 6: volts: not supported yet beside azimuth thrusters"),
        ("reaction_torque: 0.1", "line 6: reaction_torque: not supported yet beside azimuth thrusters"),
        ("names: [a, b]", "line 6: names: not supported yet beside azimuth thrusters; leave it out"),
        ("weights: [1, 1, 1, 1]", "line 6: weights: 4 numbers for 2 thrusters; give one each"),
        ("weights: []", "line 6: weights: 0 numbers for 2 thrusters; give one each"),
    ],
)
def test_a_key_that_does_not_go_with_azimuths_is_refused(key: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(VehicleError, match=said.replace("[", r"\[")):
        load(FERRY + key + "\n", tmp_path)


def test_limits_of_fixed_thrusters_are_counted_without_those_that_turn(tmp_path: Path) -> None:
    with pytest.raises(VehicleError, match="f_max: 3 numbers for 2 fixed thrusters; give one each"):
        load(MIXED.replace("[30, 40]", "[30, 40, 50]"), tmp_path)
    with pytest.raises(VehicleError, match="f_min: missing; give"):
        load(MIXED.replace("f_min: -30\n", ""), tmp_path)
    with pytest.raises(VehicleError, match=r"line 6: thrusters\[2\].direction has length 2; give a unit"):
        load(MIXED.replace("direction: [1, 0, 0]", "direction: [2, 0, 0]"), tmp_path)


def test_parts_that_do_not_go_with_azimuths_are_refused_in_scripts_too(tmp_path: Path) -> None:
    vehicle, far = load(FERRY, tmp_path), np.full((2, 4), 5.0)
    with pytest.raises(VehicleError, match="azimuths have no voltages"):
        replace(vehicle, by_volts=VoltageTable(np.array([12.0, 14.0]), -far, far))
    for corners in ([[0, 0], [0, 1], [1, 0]], PENTAGRAM, [[0, 0], [1, 0]]):
        with pytest.raises(VehicleError, match=r"not convex|three or more pairs"):
            replace(vehicle, azimuths=(Azimuth(0, np.array(corners, dtype=float)),), names=())
    with pytest.raises(VehicleError, match="azimuths need two components of f each"):
        replace(vehicle, azimuths=(vehicle.azimuths[0], vehicle.azimuths[0]), names=())


def test_another_frame_is_refused(tmp_path: Path) -> None:
    vehicle = load(FERRY, tmp_path)
    assert vehicle.with_frame("frd") is vehicle
    with pytest.raises(AllocError, match="takes no azimuth thrusters yet"):
        vehicle.with_frame("flu")


def test_the_supply_vessel_s_columns_and_limits_are_those_of_its_source() -> None:
    """thrConfig of MSS: a tunnel gives [0, 1, l_x], an azimuth [cos a, sin a, l_x sin a - l_y cos a]."""
    vessel = load_vehicle("offshore-supply-vessel")
    assert vessel.actuators == ((0,), (1,), (2, 3), (4, 5))
    f = np.array([1.0, 2.0, *3.0 * np.array([np.cos(0.4), np.sin(0.4)]), 0.0, 5.0])
    yaw = 37 * 1.0 + 35 * 2.0 + 3.0 * (-83 / 2 * np.sin(0.4) - 7 * np.cos(0.4)) - 83 / 2 * 5.0
    assert vessel.T @ f == pytest.approx([3 * np.cos(0.4), 3.0 + 3 * np.sin(0.4) + 5.0, yaw])
    assert vessel.f_max[:2].tolist() == [-x for x in vessel.f_min[:2]] == [3e5, 3e5]
    longest = [np.linalg.norm(one.corners, axis=1).max() for one in vessel.azimuths]
    assert longest == pytest.approx([4.2e5, 6.55e5])
    allocate = build("scaled", vessel)
    rng = np.random.default_rng(3)
    for tau in demands_around(vessel, rng, 6):
        assert allocate(tau).share[0] == pytest.approx(min(1.0, corners_lp(vessel, tau)), rel=1e-8)


def test_milliampere1_s_columns_are_those_that_its_source_prints() -> None:
    ferry = load_vehicle("milliampere1")
    assert ferry.T.tolist() == [
        [1, 0, 1, 0, 1, 0, 1, 0],
        [0, 1, 0, 1, 0, 1, 0, 1],
        [0.8, 1.8, -0.8, 1.8, 0.8, -1.8, -0.8, -1.8],
    ]
    assert [np.linalg.norm(one.corners, axis=1).max() for one in ferry.azimuths] == pytest.approx([300] * 4)
    scaled, daqp = build("scaled", ferry), build("qp/daqp", ferry)
    for tau in demands_around(ferry, np.random.default_rng(4), 6):
        far = corners_lp(ferry, tau)
        assert scaled(tau).share[0] == pytest.approx(min(1.0, far), rel=1e-8)
        assert daqp(0.9 * far * tau).f == pytest.approx(scaled(0.9 * far * tau).f, abs=1e-5)
