"""Demand sets whose limits move: what each is named after holds for all of its demands."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from alloc import Label, NotApplicable, Status, build, label, load_vehicle
from bench.demands import DemandSet, build_demands

VEHICLES = ("ukwial", "bluerov2-heavy")
RATE_HZ = 100


@cache
def made(name: str, vehicle: str, n: int = 60) -> DemandSet:
    return build_demands(name, load_vehicle(vehicle), 1, n)


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_slew_leaves_what_thrusters_can_reach_from_the_exact_answer_before(vehicle: str) -> None:
    """Each step is the scaled answer within the limits of that step, and the next limits lie around it."""
    demands = made("slew", vehicle)
    v = demands.vehicle
    assert v.slew is not None
    assert demands.f_min is not None
    assert demands.f_max is not None
    F, _ = build("scaled", v).many(demands.taus, demands.f_min, demands.f_max)
    if v.esc:  # thrusters make what their ESCs make of it
        F = v.commands(F, f_min=demands.f_min, f_max=demands.f_max).f
    before = np.vstack([np.zeros(v.n), F[:-1]])  # thrusters begin at rest
    np.testing.assert_allclose(
        demands.f_min, np.maximum(v.f_min, before - v.slew.down / RATE_HZ), rtol=0, atol=1e-8 * v.f_scale
    )
    np.testing.assert_allclose(
        demands.f_max, np.minimum(v.f_max, before + v.slew.up / RATE_HZ), rtol=0, atol=1e-8 * v.f_scale
    )
    assert np.abs(np.diff(F, axis=0)).max() <= v.slew.up.max() / RATE_HZ * (1 + 1e-9)


def test_sag_goes_from_a_full_battery_to_an_empty_one() -> None:
    demands = made("sag", "bluerov2-heavy")
    assert demands.f_max is not None
    assert demands.f_max[0] == pytest.approx(load_vehicle("bluerov2-heavy").limits(volts=16.8)[1])
    assert demands.f_max[-1] == pytest.approx(load_vehicle("bluerov2-heavy").limits(volts=13.0)[1])
    assert (np.diff(demands.f_max, axis=0) <= 0).all()


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_jolts_have_limits_of_every_kind(vehicle: str) -> None:
    demands = made("jolts", vehicle, 400)
    low, high = demands.limits
    assert (low > high).any(axis=1).mean() == pytest.approx(0.05, abs=0.04)
    assert (low == high).any()
    assert ((low > 0) & (low < high)).any()
    assert ((low == 0) & (high > 0)).any()
    assert {Label.ACTIVE, Label.INFEASIBLE} <= set(demands.labels)


@pytest.mark.parametrize("name", ["slew", "sag", "jolts"])
def test_labels_and_alpha_are_those_of_each_demand_s_own_limits(name: str) -> None:
    demands = made(name, "bluerov2-heavy")
    for i in range(0, 60, 7):
        low, high = (side[i] for side in demands.limits)
        alone = label(demands.vehicle, demands.taus[i : i + 1], f_min=low, f_max=high)
        assert demands.labels[i] == alone.label[0]
        assert demands.alpha[i] == pytest.approx(alone.alpha[0])
    _, status = build("nullspace", demands.vehicle).many(demands.taus, demands.f_min, demands.f_max)
    sure = demands.labels != Label.BOUNDARY
    assert ((status == Status.SOLVED) == (demands.labels != Label.INFEASIBLE))[sure].all()


def test_a_vehicle_whose_file_does_not_say_enough_has_no_such_set() -> None:
    quick = replace(load_vehicle("ukwial"), slew=None)
    with pytest.raises(NotApplicable, match="has no slew rates; add 'slew'"):
        build_demands("slew", quick, 1)
    heavy = load_vehicle("bluerov2-heavy")
    bare = replace(heavy, esc=tuple(replace(esc, nominal=float("nan")) for esc in heavy.esc))
    with pytest.raises(NotApplicable, match="curve has several voltages; add 'volts' to 'esc'"):
        build_demands("slew", bare, 1)
    with pytest.raises(NotApplicable, match="has no limits by voltage; add 'volts'"):
        build_demands("sag", quick, 1)
    heavy = load_vehicle("bluerov2-heavy")
    assert heavy.by_volts is not None
    table = replace(
        heavy.by_volts,
        volts=heavy.by_volts.volts[2:],
        f_min=heavy.by_volts.f_min[2:],
        f_max=heavy.by_volts.f_max[2:],
    )
    with pytest.raises(NotApplicable, match=r"14 to 20 V, not 13 to 16\.8 V"):
        build_demands("sag", replace(heavy, by_volts=table), 1)
