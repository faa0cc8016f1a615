"""The attainable set of thrusters that turn, against linear programs over the corners of their polygons."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from alloc import Label, NotApplicable, Vehicle, alpha_max, build, label, load_vehicle
from alloc.closed_forms.inverse import generalized_inverse
from alloc.reach.attainable import alpha_max_lp, alpha_range, beyond, closed_form_range
from alloc.reach.volumes import attainable_volume, closed_form_volume, safe_share, uniform_demands
from alloc.reach.zonotope import farthest, limit_rows, vertices, zonotope
from alloc.vehicle.azimuth import excess, nearest_thrusts
from tests.azimuths import boats, corners_lp, demands_around

BOATS = boats(40)
AGREE = 1e-8
"""Tolerance on alpha: HiGHS works to 1e-10 in scaled wrench, and alpha is a ratio of such numbers."""


def test_facets_agree_with_linear_programs_over_corners_and_over_half_planes() -> None:
    rng = np.random.default_rng(2)
    for vehicle in BOATS:
        for tau in demands_around(vehicle, rng, 4):
            expected = corners_lp(vehicle, tau)
            assert alpha_max(vehicle, [tau])[0] == pytest.approx(expected, rel=AGREE), vehicle.name
            assert alpha_max_lp(vehicle, tau) == pytest.approx(expected, rel=AGREE), vehicle.name


def test_a_failure_takes_both_components_and_leaves_what_the_others_reach() -> None:
    rng = np.random.default_rng(3)
    for vehicle in (boat for boat in BOATS if len(boat.actuators) > 3):
        failed = vehicle.with_fault(0)
        assert failed.readiness[list(vehicle.actuators[0])].tolist() == [0.0, 0.0]
        assert failed.faults == ((0, 0.0),)
        for tau in demands_around(vehicle, rng, 3) if failed.rank == 3 else ():
            assert alpha_max(failed, [tau])[0] == pytest.approx(corners_lp(failed, tau), rel=AGREE)


def test_no_thrust_within_the_polygons_reaches_beyond_a_facet_and_some_thrust_reaches_each() -> None:
    rng = np.random.default_rng(4)
    for vehicle in BOATS[:20]:
        f = rng.uniform(vehicle.f_min, vehicle.f_max, (200, vehicle.n))
        for azimuth in vehicle.azimuths:
            share = rng.dirichlet(np.ones(len(azimuth.corners)), 200)
            f[:, azimuth.components] = share @ azimuth.corners
        found = zonotope(vehicle)
        assert (f @ vehicle.TP.T / found.scale @ found.facets.T <= found.support + 1e-9).all()
        far = farthest(vehicle, found.facets @ (vehicle.TP / found.scale[:, None]))
        assert far == pytest.approx(found.support, abs=1e-9)


def test_labels_and_the_closed_form_are_judged_by_polygons() -> None:
    rng = np.random.default_rng(5)
    for vehicle in BOATS[:20]:
        taus = demands_around(vehicle, rng, 20)
        low, high = closed_form_range(vehicle, taus)
        rows = vehicle.half_planes
        assert rows is not None
        for share, inside in ((0.999, True), (1.001, False)):
            f = (taus * (share * high)[:, None]) @ generalized_inverse(vehicle).T
            within = (f @ rows.A.T <= rows.reach + 1e-9).all(axis=1)
            within &= ((f >= vehicle.f_min - 1e-9) & (f <= vehicle.f_max + 1e-9)).all(axis=1)
            assert (within == inside)[high > 1e-6].all()
        assert (label(vehicle, taus * (0.99 * high)[:, None]).label == Label.INACTIVE)[high > 1e-6].all()
        assert (low <= 0.0).all()


def test_a_demand_beyond_the_polygons_is_proven_to_be_so_and_none_within() -> None:
    rng = np.random.default_rng(6)
    for vehicle in BOATS[:20]:
        proven, taus = beyond(vehicle), demands_around(vehicle, rng, 5)
        far = alpha_max(vehicle, taus)
        edge = (taus * far[:, None])[far > 0.0]  # zero is on the edge where thrusters push to one side only
        limits = vehicle.f_min, vehicle.f_max
        assert all(proven(1.0001 * tau, *limits) and not proven(0.9999 * tau, *limits) for tau in edge)


def sums(vehicle: Vehicle) -> np.ndarray:
    """Wrenches (M, k) of all corners of all sets, one of each thruster: the set is their hull."""
    made = np.zeros((1, vehicle.k))
    for own, corners in zip(vehicle.actuators, vertices(vehicle), strict=True):
        made = (made[:, None] + corners @ vehicle.TP[:, list(own)].T).reshape(-1, vehicle.k)
    return made


def test_the_volume_is_that_of_the_hull_of_all_sums_of_corners() -> None:
    for vehicle in BOATS[:20:4] + BOATS[1:20:4]:
        hull = ConvexHull(sums(vehicle) / vehicle.row_lengths)
        assert attainable_volume(vehicle) == pytest.approx(hull.volume, rel=1e-8)


def test_demands_are_drawn_evenly_and_the_closed_form_serves_its_share_of_them() -> None:
    """Uniformity of alpha*^-3 in 0 … 1, of deviation 1/sqrt(12), where zero lies inside."""
    n = 4000
    for vehicle in (load_vehicle("double-ended-ferry"), *BOATS[:6]):
        taus = uniform_demands(vehicle, np.random.default_rng(7), n)
        reach = alpha_max(vehicle, taus)
        assert (reach >= 1 - 1e-9).all()
        if (zonotope(vehicle).support > 1e-3).all():
            assert (reach**-3.0).mean() == pytest.approx(0.5, abs=4 / np.sqrt(12 * n))
        share = closed_form_volume(vehicle) / attainable_volume(vehicle)
        low, high = closed_form_range(vehicle, taus)
        served = ((low <= 1) & (high >= 1)).mean()
        assert served == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / n) + 1e-9)


def test_the_safe_share_is_the_least_that_the_closed_form_serves_of_a_corner() -> None:
    for vehicle in BOATS[:12]:
        corners = sums(vehicle)
        corners = corners[np.abs(corners / vehicle.wrench_scale).max(axis=1) > 1e-9]
        least = min(1.0, closed_form_range(vehicle, corners)[1].min())
        assert safe_share(vehicle) == pytest.approx(max(least, 0.0), abs=1e-8)


def test_a_ray_from_another_wrench_leaves_the_set_where_a_linear_program_says() -> None:
    rng = np.random.default_rng(8)
    for vehicle in (load_vehicle("bluerov2-heavy"), *BOATS[:8]):
        start, tau = (0.3 * each for each in demands_around(vehicle, rng, 2))
        least, most = alpha_range(vehicle, [tau], start=start)
        assert most[0] == pytest.approx(alpha_max_lp(vehicle, tau, start=start), rel=AGREE, abs=AGREE)
        if np.isfinite(most[0]):
            assert least[0] == pytest.approx(-alpha_max_lp(vehicle, -tau, start=start), rel=AGREE, abs=AGREE)
        low, high = closed_form_range(vehicle, [tau], start)
        for alpha in (low[0], high[0]) if low[0] <= high[0] else ():
            f = generalized_inverse(vehicle) @ (start + alpha * tau)
            rows = limit_rows(vehicle)
            assert (rows.A @ f - rows.reach).max() == pytest.approx(0.0, abs=1e-9 * vehicle.f_scale)


def test_the_nearest_thrusts_lie_within_and_no_corner_is_on_their_far_side() -> None:
    """Nearest point f' of a convex set to f: (f - f')'(v - f') <= 0 for each of its corners v."""
    rng = np.random.default_rng(9)
    for vehicle in BOATS[:20]:
        F = rng.uniform(-300.0, 300.0, (50, vehicle.n))
        near = nearest_thrusts(vehicle.turning, F, vehicle.f_min, vehicle.f_max)
        rows = limit_rows(vehicle)
        assert (near @ rows.A.T <= rows.reach + 1e-9).all()
        for own, corners in zip(map(list, vehicle.actuators), vertices(vehicle), strict=True):
            past, ahead = (F - near)[:, own], corners[None] - near[:, None, own]
            assert (np.einsum("ij,ikj->ik", past, ahead) <= 1e-7).all()
        assert nearest_thrusts(vehicle.turning, near, vehicle.f_min, vehicle.f_max) == pytest.approx(near)


def test_the_excess_of_a_thruster_is_that_over_its_worst_limit() -> None:
    rng = np.random.default_rng(10)
    for vehicle in BOATS[:10]:
        F = rng.uniform(-200.0, 200.0, (20, vehicle.n))
        beyond = excess(vehicle.turning, F, vehicle.f_min, vehicle.f_max, 0.0)
        rows = limit_rows(vehicle)
        over = F @ rows.A.T - rows.reach
        for own in vehicle.actuators:
            touched = np.abs(rows.A[:, list(own)]).sum(axis=1) > 0.0
            touched[: 2 * vehicle.n] &= len(own) == 1  # the box around a polygon is no limit of its own
            for component in own:
                assert beyond[:, component] == pytest.approx(over[:, touched].max(axis=1), abs=1e-9)


def test_limits_of_a_call_are_refused() -> None:
    vehicle, taus = BOATS[0], [[1.0, 0.0, 0.0]]
    assert alpha_max(vehicle, taus, f_min=vehicle.f_min) == alpha_max(vehicle, taus)
    for others in (0.5 * vehicle.f_min, np.zeros(2)):
        with pytest.raises(NotApplicable, match="a call with f_min, f_max takes no azimuth thrusters yet"):
            alpha_max(vehicle, taus, f_min=others)


def test_the_method_that_a_refusal_of_too_many_facets_names_takes_the_vehicle(tmp_path: Path) -> None:
    """Red before: nullspace was named, which refuses d = 4."""
    turning = [f"{{position: [{at}, 0], azimuth: {{max: 100}}}}" for at in ("2, 1", "2, -1", "-2, 1")]
    upright = [
        f"{{position: [{at}, 0], direction: [0, 0, 1]}}" for at in ("1, 1", "-1, 1", "-1, -1", "1, -1")
    ]
    file = tmp_path / "boat.yaml"
    file.write_text(
        f"name: boat\ndof: [surge, sway, heave, roll, pitch, yaw]\nf_min: -40\nf_max: 30\n"
        f"thrusters: [{', '.join(turning + upright)}]\n"
    )
    boat = load_vehicle(file)
    with pytest.raises(NotApplicable, match="than 50000 facets; give them fewer sides, or") as refusal:
        build("scaled", boat)
    build(str(refusal.value).split()[-1], boat)
