"""The attainable set of thrusters that turn, against linear programs over the corners of their polygons."""

from collections.abc import Callable

import numpy as np
import pytest

from alloc import Label, NotApplicable, Vehicle, alpha_max, label
from alloc.closed_forms.inverse import generalized_inverse
from alloc.reach.attainable import alpha_max_lp, beyond, closed_form_range
from alloc.reach.volumes import attainable_volume, closed_form_volume, safe_share
from alloc.reach.zonotope import farthest, zonotope
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


@pytest.mark.parametrize("volume", [attainable_volume, closed_form_volume, safe_share])
def test_volumes_of_such_sets_are_refused(volume: Callable[[Vehicle], float]) -> None:
    with pytest.raises(NotApplicable, match="takes no azimuth thrusters yet"):
        volume(BOATS[0])


def test_limits_of_a_call_are_refused() -> None:
    vehicle, taus = BOATS[0], [[1.0, 0.0, 0.0]]
    assert alpha_max(vehicle, taus, f_min=vehicle.f_min) == alpha_max(vehicle, taus)
    for others in (0.5 * vehicle.f_min, np.zeros(2)):
        with pytest.raises(NotApplicable, match="f_min, f_max of a call: takes no azimuth thrusters yet"):
            alpha_max(vehicle, taus, f_min=others)
