"""Sets of forces of several convex pieces: what of rings, wide arcs and zones the pieces hold, and lose."""

from math import cos, pi
from pathlib import Path

import numpy as np
import pytest

from alloc import NotApplicable, Vehicle, load_vehicle
from alloc.errors import VehicleError
from alloc.vehicle.azimuth import Azimuth, excess, nearest_thrusts
from alloc.vehicle.pieces import combinations, ring_pieces, sector_pieces
from tests.azimuths import FERRY

Arc = tuple[float, float]


def load(bow: str, folder: Path) -> Vehicle:
    file = folder / "boat.yaml"
    file.write_text(FERRY.replace("{max: 100}", bow, 1))
    return load_vehicle(file)


def holds(azimuth: Azimuth, forces: np.ndarray, spare: float = 0.0) -> np.ndarray:
    """Mask of forces (N, 2) that lie in one of the polygons, by cross products with their edges."""
    found = np.zeros(len(forces), dtype=bool)
    for part in azimuth.parts:
        inside = np.ones(len(forces), dtype=bool)
        for a, b in zip(part.corners, np.roll(part.corners, -1, axis=0), strict=True):
            to = forces - a
            inside &= (b[0] - a[0]) * to[:, 1] - (b[1] - a[1]) * to[:, 0] >= -spare
        found |= inside
    return found


def free(forces: np.ndarray, least: float, arcs: list[Arc], spare: float) -> np.ndarray:
    """Mask of forces (N, 2) of 100 N at most, ``least`` N at least, at angles within arcs."""
    sizes, angles = np.hypot(*forces.T), np.degrees(np.arctan2(forces[:, 1], forces[:, 0]))
    within = [(angles - low + spare) % 360.0 <= high - low + 2 * spare for low, high in arcs]
    allowed: np.ndarray = (sizes <= 100 + spare) & (sizes >= least - spare) & np.logical_or.reduce(within)
    return allowed


SETS = [
    ("{max: 100, forbidden_deg: [[178, 182]]}", 0.0, [(-178.0, 178.0)], 2),
    ("{max: 100, sector_deg: [-100, 100]}", 0.0, [(-100.0, 100.0)], 2),
    ("{max: 100, forbidden_deg: [[170, 190]]}", 0.0, [(-170.0, 170.0)], 2),
    ("{max: 100, sector_deg: [-90, 90], forbidden_deg: [[-10, 10]]}", 0.0, [(-90.0, -10.0), (10.0, 90.0)], 2),
    ("{max: 100, forbidden_deg: [[-20, 20], [100, 130]]}", 0.0, [(20.0, 100.0), (130.0, 340.0)], 3),
    ("{max: 100, min: 10}", 10.0, [(-180.0, 180.0)], 6),
    ("{max: 100, min: 40, sides: 24}", 40.0, [(-180.0, 180.0)], 16),
    ("{max: 100, min: 20, sector_deg: [-30, 80]}", 20.0, [(-30.0, 80.0)], 3),
    ("{max: 100, min: 5, forbidden_deg: [[80, 100], [-100, -80]]}", 5.0, [(-80.0, 80.0), (100.0, 260.0)], 4),
]


@pytest.mark.parametrize(("bow", "least", "arcs", "count"), SETS)
def test_pieces_hold_no_force_that_the_file_forbids_and_all_but_what_is_stated(
    bow: str, least: float, arcs: list[Arc], count: int, tmp_path: Path
) -> None:
    azimuth = load(bow, tmp_path).azimuths[0]
    assert len(azimuth.parts) == count
    rng = np.random.default_rng(3)
    for part in azimuth.parts:
        drawn = rng.dirichlet(np.full(len(part.corners), 0.3), 4000) @ part.corners
        drawn = np.vstack([drawn, part.corners, (part.corners + np.roll(part.corners, 1, axis=0)) / 2])
        moved = drawn[np.hypot(*drawn.T) > 1e-6]
        assert free(moved, least, arcs, 1e-6).all()
    sides = 24 if "sides: 24" in bow else 16
    lost = 100 * (1 - cos(pi / sides))
    forces = rng.uniform(-100, 100, (20_000, 2))
    sizes = np.hypot(*forces.T)
    kept = (sizes <= 100 - lost) & (sizes >= (least + lost if least else 0.0))
    surely = free(forces, least, arcs, -0.01) & kept
    assert surely.sum() > 1000
    assert holds(azimuth, forces[surely], 1e-6).all()


def test_half_discs_of_a_wide_arc_overlap_and_a_narrow_one_stays_whole() -> None:
    assert len(sector_pieces(50.0, (-180.0, 180.0), 16)) == len(sector_pieces(50.0, (10.0, 190.0), 16)) == 1
    first, second = sector_pieces(50.0, (-150.0, 150.0), 16)
    assert first[0] == pytest.approx([50 * cos(np.radians(150)), -50 * np.sin(np.radians(150))])
    assert second[-1] == pytest.approx([50 * cos(np.radians(150)), 50 * np.sin(np.radians(150))])


def test_the_sector_that_a_zone_leaves_starts_within_half_a_turn_of_ahead(tmp_path: Path) -> None:
    zone = "{max: 100, forbidden_deg: [[-10, 10]]}"
    assert load(zone, tmp_path).azimuths[0].sector == (10.0, 350.0)


def test_a_ring_s_inner_edge_loses_no_more_newtons_than_its_outer_one() -> None:
    angles = np.radians(np.arange(0.03, 360.0, 0.1))  # none is parallel to a side
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    for least, sides in ((5.0, 16), (20.0, 16), (60.0, 12), (80.0, 32)):
        inner, outer = np.full(len(rays), np.inf), np.zeros(len(rays))
        for corners in ring_pieces(least, 100.0, (-180.0, 180.0), sides):
            part = Azimuth(0, corners)
            along = rays @ part.normals.T
            near = np.where(along < 0, part.reach / np.where(along < 0, along, -1), 0.0).max(axis=1)
            far = np.where(along > 0, part.reach / np.where(along > 0, along, 1), np.inf).min(axis=1)
            inner = np.where(near <= far, np.minimum(inner, near), inner)
            outer = np.where(near <= far, np.maximum(outer, far), outer)
        lost = 100 * (1 - cos(pi / sides))
        assert least - 1e-9 <= inner.min()
        assert inner.max() <= least + lost + 1e-9
        assert 100 - lost - 1e-9 <= outer.min()
        assert outer.max() <= 100 + 1e-9


def test_combinations_are_all_choices_of_one_piece_a_working_thruster(tmp_path: Path) -> None:
    vehicle = load("{max: 100, min: 10}", tmp_path)
    each = combinations(vehicle)
    assert len(each) == 6
    assert {id(one.azimuths[1]) for one in each} == {id(vehicle.azimuths[1])}
    assert [one.azimuths[0].corners.tolist() for one in each] == [
        p.tolist() for p in vehicle.azimuths[0].pieces
    ]
    assert len(combinations(vehicle.with_fault("bow"))) == 1
    convex = load("{max: 100}", tmp_path)
    assert combinations(convex) == (convex,)


def test_the_nearest_force_of_several_pieces_is_that_of_the_nearest_one(tmp_path: Path) -> None:
    vehicle = load("{max: 100, sector_deg: [-90, 90], forbidden_deg: [[-60, 60]]}", tmp_path)
    F = np.array([[50.0, 10.0, 0.0, 0.0], [50.0, -10.0, 0.0, 0.0], [10.0, 60.0, 0.0, 0.0]])
    near = nearest_thrusts(vehicle.turning, F, vehicle.f_min, vehicle.f_max)
    ray = np.array([cos(pi / 3), np.sin(pi / 3)])
    assert near[0, :2] == pytest.approx(ray * (F[0, :2] @ ray))
    assert near[1, :2] == pytest.approx([near[0, 0], -near[0, 1]])
    assert near[2].tolist() == F[2].tolist()
    beyond = excess(vehicle.turning, F, vehicle.f_min, vehicle.f_max, 0.0)[:, 0]
    assert beyond[0] == pytest.approx(np.linalg.norm(F[0, :2] - near[0, :2]))
    assert beyond[2] < 0.0


def test_what_is_known_of_convex_sets_alone_is_refused_in_words(tmp_path: Path) -> None:
    vehicle = load("{max: 100, min: 10}", tmp_path)
    for asked in (lambda: vehicle.half_planes, lambda: vehicle.azimuths[0].normals):
        with pytest.raises(
            NotApplicable, match=r"azimuth: 6 convex pieces, and what is asked for takes sets of"
        ):
            asked()


@pytest.mark.parametrize(
    ("bow", "said"),
    [
        (
            "{max: 100, min: 97}",
            "azimuth.min: is 97; a ring of 16 sides up to 100 N needs less than 96.16: give",
        ),
        ("{max: 100, min: 1, sides: 3}", "azimuth.min: is 1; a ring of 3 sides up to 100 N needs less than"),
    ],
)
def test_a_ring_too_thin_for_convex_pieces_is_refused(bow: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(VehicleError) as refused:
        load(bow, tmp_path)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_more_combinations_than_are_tried_are_refused_with_their_number(tmp_path: Path) -> None:
    file = tmp_path / "boat.yaml"
    file.write_text(FERRY.replace("{max: 100}", "{max: 100, min: 45, sides: 24}"))
    with pytest.raises(VehicleError) as refused:
        load_vehicle(file)
    assert "line 3: thrusters" in str(refused.value)
    assert "17 x 17 = 289 combinations of convex pieces, and 256 are tried at most" in str(refused.value)
