"""A proof of infeasibility: for every demand beyond the edge, for none inside, whatever the limits are."""

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.reach import attainable as module
from alloc.reach.attainable import alpha_range, beyond
from bench.demands.sets.jolts import limited_demands


@pytest.mark.parametrize("enumerated", [5_000, 0])
@pytest.mark.parametrize("name", ["ukwial", "bluerov2-heavy", "supply-vessel"])
def test_demands_beyond_the_edge_are_proven_infeasible_and_those_inside_are_not(
    name: str, enumerated: int, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator
) -> None:
    """With no facets enumerated the direction is the step from the nearest attainable wrench."""
    monkeypatch.setattr(module, "ENUMERATED", enumerated)
    vehicle = load_vehicle(name)
    proven = beyond(vehicle)
    taus, lows, highs, _ = limited_demands(vehicle, rng, 150)
    least, most = alpha_range(vehicle, taus, lows, highs)
    checked = 0
    for tau, low, high, inner, outer in zip(taus, lows, highs, least, most, strict=True):
        # alpha* is known to rounding where limits leave the attainable set some extent along tau.
        if not 1e-3 < outer < 1e3 or outer - inner < 1e-3 * outer:
            continue
        assert proven(tau * outer * (1 + 1e-6), low, high)
        assert not proven(tau * outer * (1 - 1e-6), low, high)
        checked += 1
    assert checked > 20


def test_a_demand_on_the_edge_is_not_proven_infeasible_by_rounding(rng: np.random.Generator) -> None:
    """Thrusts at their limits push these demands exactly, but for rounding."""
    vehicle = load_vehicle("bluerov2-heavy")
    proven = beyond(vehicle)
    corners = np.where(rng.random((200, vehicle.n)) < 0.5, vehicle.f_min, vehicle.f_max)
    assert not any(proven(tau, vehicle.f_min, vehicle.f_max) for tau in corners @ vehicle.TP.T)
