"""The growth study: generated vehicles, and exponents fitted to what was measured."""

import numpy as np
import pytest

import alloc.attainable
from alloc import UnknownName, alpha_range
from bench.studies.growth import growth_vehicle, growth_vehicles, settings


def test_every_generated_vehicle_moves_along_all_its_axes_and_well_conditioned() -> None:
    for vehicle in growth_vehicles():
        assert vehicle.rank == vehicle.k
        assert np.linalg.cond(vehicle.T) < 10


def test_a_generated_vehicle_is_the_same_each_time() -> None:
    np.testing.assert_array_equal(growth_vehicle("growth-k6-n8").T, growth_vehicle("growth-k6-n8").T)


@pytest.mark.parametrize("name", ["growth-k3-n3", "growth-k6-n65", "growth-k4-n8", "growth-"])
def test_a_size_outside_the_study_is_refused(name: str) -> None:
    with pytest.raises(UnknownName, match="growth-k3-n4"):
        growth_vehicle(name)


def test_the_study_s_vehicles_are_found_by_the_names_in_its_settings() -> None:
    assert [growth_vehicle(name).name for name in settings().vehicles] == list(settings().vehicles)


def test_too_many_facets_to_enumerate_give_the_same_ranges_by_linear_programs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    vehicle = growth_vehicle("growth-k6-n8")
    taus = np.random.default_rng(0).standard_normal((5, 6)) * vehicle.wrench_scale / 4
    by_facets = alpha_range(vehicle, taus)
    monkeypatch.setattr(alloc.attainable, "FACETS", 0)
    for expected, found in zip(by_facets, alpha_range(vehicle, taus), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-7)
