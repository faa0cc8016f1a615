"""The numbers of layouts side by side against the library's functions for one vehicle at a time."""

from itertools import combinations

import numpy as np
import pytest

from alloc import Vehicle, alpha_max, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.reach.attainable import single_axis_maxima
from alloc.reach.volumes import (
    attainable_volume,
    closed_form_volume,
    safe_share,
    uniform_demands,
    worst_fault,
)
from alloc.reach.zonotope import zonotope
from alloc.vehicle.geometry import DOF
from bench.judging.capability import remaining_authority
from bench.judging.loss import loss
from bench.layouts.authority import closed_form_volumes, volumes
from bench.layouts.compile import compile_study
from bench.layouts.measure import Columns, numbers, refused
from bench.layouts.run import count_layouts
from bench.layouts.shards import tasks, values
from bench.layouts.space import PlacedThrusters, poses
from bench.layouts.spaces import Layouts, dependencies, inverse, minors, single_layout, spaces, subsets
from bench.layouts.study import Constraints, MountingBox, Wake, read_study
from tests.places import ROOT

COUNT = 5
"""Layouts of each kind: one by one they take most of the time."""


def some_layouts(k: int, n: int, kind: str, rng: np.random.Generator) -> Layouts:
    """COUNT layouts: of random columns, in two blocks that share nothing, or with different weights."""
    T = rng.normal(size=(k, n, COUNT))
    if kind == "blocks":
        T[: k // 2, n // 2 :] = T[k // 2 :, : n // 2] = 0.0
    return Layouts(
        T=T,
        weights=rng.uniform(0.5, 2.0, (n, COUNT)) if kind == "weights" else np.ones((n, COUNT)),
        f_min=-rng.uniform(10.0, 30.0, (n, COUNT)),
        f_max=rng.uniform(20.0, 40.0, (n, COUNT)),
    )


def vehicle_of(layouts: Layouts, i: int) -> Vehicle:
    """One layout as a vehicle."""
    k, n, _ = layouts.T.shape
    return Vehicle(
        name="layout",
        dof=DOF[:k],
        T=layouts.T[..., i],
        H=np.diag(layouts.weights[:, i]),
        f_min=layouts.f_min[:, i],
        f_max=layouts.f_max[:, i],
        readiness=np.ones(n),
        slack_weights=np.ones(k),
        weak_limit=0.0,  # numbers, not a survey's
    )


def pairs_left(vehicle: Vehicle) -> list[tuple[int, float]]:
    """Rank and volume after the failure of each pair of thrusters; volume 0 where rank is lost."""
    left = [vehicle.with_fault(i).with_fault(j) for i, j in combinations(range(vehicle.n), 2)]
    return [(v.rank, attainable_volume(v) if v.rank == vehicle.k else 0.0) for v in left]


@pytest.mark.parametrize(
    ("k", "n", "kind"),
    [(6, 8, ""), (6, 8, "blocks"), (6, 8, "weights"), (3, 4, ""), (3, 6, "weights"), (5, 5, ""), (1, 3, "")],
)
def test_numbers_side_by_side_are_those_of_each_vehicle_alone(
    k: int, n: int, kind: str, rng: np.random.Generator
) -> None:
    layouts = some_layouts(k, n, kind, rng)
    taus = uniform_demands(vehicle_of(layouts, 0), rng, 24)
    full, columns = numbers(layouts, DOF[:k], taus, np.ones(k), 1.0)
    assert full.all()
    for i in range(COUNT):
        check_one(vehicle_of(layouts, i), {name: column[i : i + 1] for name, column in columns.items()}, taus)


def check_one(vehicle: Vehicle, numbers: Columns, taus: FloatArray) -> None:
    """Every number of a layout is the library's; 1e-9 is far above the rounding of both, 1e-12."""
    unit = vehicle.row_lengths.prod()  # the library's volumes are over the vehicle's own row lengths
    worst = vehicle.with_fault(worst_fault(vehicle))
    ranks, sizes = zip(*pairs_left(vehicle), strict=True)
    z = zonotope(vehicle)
    closed, exact = build("pinv", vehicle), build("nullspace", vehicle)
    F, best = closed.many(taus)[0], exact.many(taus)[0]
    backward, forward = single_axis_maxima(vehicle)
    effort = np.einsum("ij,jk,ik->i", best, vehicle.H, best)
    weighed = np.linalg.inv(vehicle.H) @ vehicle.T.T
    G = weighed @ np.linalg.inv(vehicle.T @ weighed)
    left = [np.delete(vehicle.T, i, axis=1) @ np.delete(G, i, axis=0) for i in range(vehicle.n)]
    expected = {
        "authority": attainable_volume(vehicle) * unit,
        "authority_after_one": attainable_volume(worst) * unit if worst.rank == vehicle.k else 0.0,
        "rank_after_one": worst.rank,
        "rank_after_two": min(ranks),
        "authority_after_two": min(zip(ranks, sizes, strict=True))[1] * unit,
        "condition": remaining_authority(vehicle)[0].condition,
        "unannounced_share": 1 - max(np.linalg.norm(np.eye(vehicle.k) - made, 2) for made in left),
        "safe_share": safe_share(vehicle),
        "any_direction_N": (z.support / np.linalg.norm(z.facets / z.scale, axis=1)).min(),
        "closed_form_served_share": loss(vehicle, taus, F, best)["within_1pct_share"],
        "exact_served_share": np.isfinite(best).all(axis=1).mean(),
        "exact_effort_N2": np.nanmean(effort) if np.isfinite(effort).any() else np.nan,
        "worst_case_steps": getattr(exact, "worst_case_steps", np.nan),
    }
    for row, axis in enumerate(vehicle.dof):
        of_axis = "Nm" if axis in DOF[3:] else "N"
        expected |= {f"{axis}_min_{of_axis}": backward[row], f"{axis}_max_{of_axis}": forward[row]}
    for name, value in expected.items():
        np.testing.assert_allclose(numbers[name][0], value, rtol=1e-9, err_msg=name)


@pytest.mark.parametrize(
    ("k", "n", "kind"), [(3, 4, "weights"), (3, 5, ""), (5, 7, "weights"), (6, 8, "blocks")]
)
def test_a_closed_form_s_volume_is_that_of_its_vertices_hull(
    k: int, n: int, kind: str, rng: np.random.Generator
) -> None:
    layouts = some_layouts(k, n, kind, rng)
    found = closed_form_volumes(layouts, spaces(layouts)[1])
    for i in range(2):  # Qhull is slow
        vehicle = vehicle_of(layouts, i)
        expected = closed_form_volume(vehicle) * vehicle.row_lengths.prod()
        np.testing.assert_allclose(found[i], expected, rtol=1e-9)


def test_symmetric_layouts_closed_forms_have_the_volumes_of_their_hulls() -> None:
    """Turned by the same angles, limits of thrusters add up to the same, and faces touch."""
    study = read_study(ROOT / "docs" / "layouts" / "ten-degrees.yaml")
    space, _ = compile_study(study)
    (task,) = tasks(0, count_layouts(study, space, None), "grid", 0)
    (group,) = poses(space, values(space, task)[:, ::3])
    layouts = group.layouts(space.dof)
    full, found = spaces(layouts)
    assert full.all()
    for i, volume in enumerate(closed_form_volumes(layouts, found)):
        vehicle = vehicle_of(layouts, i)
        expected = closed_form_volume(vehicle) * vehicle.row_lengths.prod()
        np.testing.assert_allclose(volume, expected, rtol=1e-9)


def test_a_symmetric_vehicle_s_closed_form_has_the_volume_that_its_two_halves_make() -> None:
    """Faces that only touch the section, as symmetry makes them, count neither twice nor not at all.

    The BlueROV2 Heavy is two vehicles of four thrusters that share nothing, so their shares multiply.
    """
    heavy = load_vehicle("bluerov2-heavy")
    whole = single_layout(heavy)
    halves = []
    for rows, columns in (([0, 1, 5], [0, 1, 2, 3]), ([2, 3, 4], [4, 5, 6, 7])):
        half = Layouts(
            T=whole.T[np.ix_(rows, columns)],
            weights=whole.weights[columns],
            f_min=whole.f_min[columns],
            f_max=whole.f_max[columns],
        )
        found = spaces(half)[1]
        halves.append(closed_form_volumes(half, found)[0] / volumes(half, found).whole[0])
    found = spaces(whole)[1]
    share = closed_form_volumes(whole, found)[0] / volumes(whole, found).whole[0]
    assert share == pytest.approx(halves[0] * halves[1], rel=1e-10)
    assert share == pytest.approx(closed_form_volume(heavy) / attainable_volume(heavy), rel=1e-9)


def test_where_the_exact_method_takes_too_many_steps_facets_say_what_is_attainable(
    rng: np.random.Generator,
) -> None:
    layouts = some_layouts(3, 13, "", rng)
    taus = 1.3 * uniform_demands(vehicle_of(layouts, 0), rng, 40)
    _, columns = numbers(layouts, DOF[:3], taus, np.ones(3), 1.0)
    for i in range(COUNT):
        expected = (alpha_max(vehicle_of(layouts, i), taus) >= 1).mean()
        assert columns["exact_served_share"][i] == pytest.approx(expected)
    assert 0 < columns["exact_served_share"].min() < 1
    for empty in ("worst_case_steps", "exact_effort_N2"):
        assert np.isnan(columns[empty]).all()


def test_layouts_that_do_not_push_every_axis_have_no_numbers(rng: np.random.Generator) -> None:
    layouts = some_layouts(3, 4, "", rng)
    layouts.T[2, :, 1] = layouts.T[1, :, 1]  # two axes that only move together
    full, columns = numbers(layouts, DOF[:3], np.ones((4, 3)), np.ones(3), 1.0)
    assert full.tolist() == [True, False, True, True, True]
    assert len(columns["authority"]) == COUNT - 1
    few = some_layouts(3, 2, "", rng)
    assert not numbers(few, DOF[:3], np.ones((4, 3)), np.ones(3), 1.0)[0].any()


@pytest.mark.parametrize(("n", "d"), [(1, 1), (4, 1), (8, 2), (9, 3), (7, 5)])
def test_minors_are_the_determinants_of_all_d_rows(n: int, d: int, rng: np.random.Generator) -> None:
    A = rng.normal(size=(n, d, 3))
    by_elimination = [np.linalg.det(A[list(rows)].transpose(2, 0, 1)) for rows in combinations(range(n), d)]
    np.testing.assert_allclose(minors(A), by_elimination, rtol=1e-10, atol=1e-12)


def test_minors_of_a_matrix_and_of_its_null_space_are_in_one_ratio(rng: np.random.Generator) -> None:
    T = rng.normal(size=(6, 8))
    N = np.linalg.svd(T)[2][6:].T
    of_T = [abs(np.linalg.det(np.delete(T, rows, axis=1))) for rows in subsets(8, 2)]
    np.testing.assert_allclose(
        np.sqrt(np.linalg.det(T @ T.T)) * np.abs(minors(N[..., None])[:, 0]), of_T, rtol=1e-10
    )


@pytest.mark.parametrize(("n", "d"), [(5, 0), (4, 1), (8, 2), (6, 3)])
def test_dependencies_combine_rows_to_zero(n: int, d: int, rng: np.random.Generator) -> None:
    A = rng.normal(size=(n, d, 2))
    y = dependencies(minors(A), n, d)
    for rows, coefficients in zip(subsets(n, d + 1), y, strict=True):
        assert np.abs(coefficients).max() > 0
        np.testing.assert_allclose(np.einsum("pb,pdb->db", coefficients, A[rows]), 0.0, atol=1e-12)


@pytest.mark.parametrize("d", [1, 2, 3, 4])
def test_an_inverse_by_cofactors_is_the_inverse_and_a_singular_matrix_has_none(
    d: int, rng: np.random.Generator
) -> None:
    A = rng.normal(size=(d, d, 5))
    A[..., 4] = 0.0
    found = inverse(A, 1e-9)
    for i in range(4):
        np.testing.assert_allclose(found[..., i] @ A[..., i], np.eye(d), atol=1e-9)
    assert (found[..., 4] == 0).all()


def two(second: list[float], f_min: float = -10.0) -> PlacedThrusters:
    """A thruster at the origin that pushes ahead, and another one to port of it, or where it is said."""
    return PlacedThrusters(
        which=np.arange(1),
        position=np.array([[0.0, 0.0, 0.0], second])[..., None],
        direction=np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])[..., None],
        center=np.zeros((3, 1)),
        f_min=np.full((2, 1), f_min),
        f_max=np.full((2, 1), 10.0),
        weights=np.ones((2, 1)),
    )


def broken(poses: PlacedThrusters, constraints: Constraints) -> list[str]:
    """The constraints that the only layout breaks."""
    return [reason for reason, which in refused(poses, constraints).items() if which.all()]


def test_a_thruster_outside_of_the_box_is_refused_and_on_its_edge_is_not() -> None:
    box = Constraints(box=MountingBox(x=(0.0, 1.0), z=(-1.0, 1.0)))
    assert broken(two([1.0, 5.0, 0.0]), box) == []
    assert broken(two([1.01, 5.0, 0.0]), box) == ["box.x"]
    assert broken(two([1.0, 5.0, -1.01]), box) == ["box.z"]


def test_thrusters_nearer_than_the_distance_are_refused() -> None:
    near = Constraints(distance=0.5)
    assert broken(two([0.3, 0.4, 0.0]), near) == []
    assert broken(two([0.3, 0.39, 0.0]), near) == ["distance"]


@pytest.mark.parametrize(
    ("second", "f_min", "hit"),
    [
        ([-0.5, 0.05, 0.0], -10.0, True),  # astern: where water goes that is pushed to go ahead
        ([-0.5, 0.15, 0.0], -10.0, False),  # beside the jet
        ([-1.5, 0.05, 0.0], -10.0, False),  # beyond its reach
        ([0.5, 0.05, 0.0], -10.0, True),  # ahead, when it reverses
        ([0.5, 0.05, 0.0], 0.0, False),  # ahead of a thruster that can't
    ],
)
def test_a_thruster_in_a_jet_is_refused(second: list[float], f_min: float, hit: bool) -> None:
    jet = Constraints(wake=Wake(length=1.0, radius=0.1))
    assert (broken(two(second, f_min), jet) == ["wake"]) is hit


def test_a_jet_widens_by_its_spread() -> None:
    aside = two([-0.5, 0.15, 0.0])
    assert broken(aside, Constraints(wake=Wake(length=1.0, radius=0.1, spread_deg=10.0))) == ["wake"]
