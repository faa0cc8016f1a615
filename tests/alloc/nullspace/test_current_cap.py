"""A cap on the path of least effort: shares at which its current meets the cap, and refusals."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from alloc import Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.discovery import Entry
from alloc.errors import DemandError, VehicleError
from alloc.reach.edge import start
from alloc.vehicle.current import PowerLaw

HONOUR = {"scaled", "scaled-by-group", "frugal", "cap-by-ratio", "cap-by-thruster"}
"""Methods that take a cap."""


def by_law(vehicle: Vehicle) -> Vehicle:
    """The vehicle with currents by a power law."""
    return replace(vehicle, esc=(replace(vehicle.esc[0], current=PowerLaw(0.076, 0.11, 1.5)),) * vehicle.n)


HEAVY = load_vehicle("bluerov2-heavy")
CASES = {
    "a table": HEAVY,
    "a law": by_law(HEAVY),
    "T without full rank": load_vehicle("bluerov2"),
    "one off": HEAVY.with_fault(1),
    "two off, a weak axis": HEAVY.with_fault(4).with_fault(5),
    "no thruster stands still": replace(HEAVY, f_min=np.full(8, 1.0)),
}
Call = tuple[FloatArray, FloatArray, FloatArray, float, float]


def calls(vehicle: Vehicle, rng: np.random.Generator, n: int) -> Iterator[Call]:
    """Demands up to twice as large as thrusters make, with limits, cap [A] and voltage [V] of the call."""
    for _ in range(n):
        F = rng.uniform(vehicle.f_min, vehicle.f_max)
        narrower = rng.uniform(0.3, 1.0, (2, vehicle.n)) ** rng.integers(2)
        low = np.where(vehicle.f_min < 0, narrower[0] * vehicle.f_min, vehicle.f_min)
        cap, volts = rng.choice([3.0, 10.0, 20.0, 60.0]), rng.uniform(10, 20)
        yield rng.uniform(0.2, 2.0) * vehicle.TP @ F, low, narrower[1] * vehicle.f_max, cap, volts


@pytest.mark.parametrize("count", [12, pytest.param(200, marks=pytest.mark.long)])
@pytest.mark.parametrize("method", ["scaled", "scaled-by-group"])
@pytest.mark.parametrize("case", CASES)
def test_shares_are_those_of_a_bisection_on_the_path_without_a_cap(
    case: str, method: str, count: int, rng: np.random.Generator
) -> None:
    vehicle, stopped = CASES[case], 0
    allocate = build(method, vehicle)
    for tau, low, high, cap, volts in calls(vehicle, rng, count):
        draw, begin = vehicle.draw(volts), vehicle.strong.TP @ start(low, high)
        whole, found = allocate(tau, low, high), allocate(tau, low, high, cap=cap, volts=volts)
        np.testing.assert_array_equal(found.amps, draw.amps(found.f))
        assert np.sum(found.amps) <= cap
        if draw.amps(whole.f).sum() <= cap:
            assert (found.status, found.share) == (whole.status, whole.share)
            continue
        stopped += 1
        least, most = 0.0, max(whole.share)
        for _ in range(40):
            middle = (least + most) / 2
            f = allocate(begin + middle * (tau - begin), low, high).f
            least, most = (middle, most) if draw.amps(f).sum() <= cap else (least, middle)
        there = allocate(begin + least * (tau - begin), low, high)
        assert found.status == Status.PARTIAL
        np.testing.assert_allclose(found.share, least * np.array(there.share), atol=1e-6)
        np.testing.assert_allclose(found.f, there.f, atol=1e-4)
    assert stopped > 4


def test_a_cap_that_comes_before_any_limit_leaves_its_power_of_two_thirds(rng: np.random.Generator) -> None:
    vehicle = CASES["a law"]
    allocate, pinv = build("scaled", vehicle), build("pinv", vehicle)
    for tau in rng.normal(size=(20, 6)) * vehicle.wrench_scale:
        f = pinv(tau).f
        whole = vehicle.draw(12.0).amps(f).sum()
        for cap in (0.0, 1.0, 3.0):
            found, share = allocate(tau, cap=cap, volts=12.0), min(1.0, (cap / whole) ** (2 / 3))
            np.testing.assert_allclose(found.f, share * f, rtol=1e-6, atol=1e-9)
            assert found.share[0] == pytest.approx(share, rel=1e-6)
            assert np.sum(found.amps) <= cap


def test_many_answers_as_single_calls(rng: np.random.Generator) -> None:
    taus = rng.normal(size=(5, 6)) * HEAVY.wrench_scale
    allocate = build("scaled", HEAVY)
    F, status = allocate.many(taus, cap=20.0, volts=12.0)
    for tau, f, one in zip(taus, F, status, strict=True):
        single = allocate(tau, cap=20.0, volts=12.0)
        np.testing.assert_array_equal(single.f, f)
        assert single.status == one


def test_a_cap_that_rest_exceeds_is_infeasible_and_one_of_all_changes_nothing() -> None:
    vehicle = CASES["no thruster stands still"]
    tau = vehicle.TP @ np.full(8, 20.0)
    allocate = build("scaled", vehicle)
    refused = allocate(tau, cap=0.1, volts=12.0)
    assert refused.status == Status.INFEASIBLE
    assert np.isnan(refused.f).all()
    np.testing.assert_array_equal(allocate(tau, cap=1e6, volts=12.0).f, allocate(tau).f)


@pytest.mark.parametrize("cap", [-1.0, np.nan, np.inf, "much"])
def test_a_cap_that_is_no_number_of_amperes_is_refused(cap: float) -> None:
    with pytest.raises(DemandError, match=r"^cap: got .*, expected a finite number of amperes"):
        build("scaled", HEAVY)(np.ones(6), cap=cap)


def test_a_cap_of_a_vehicle_without_currents_is_refused() -> None:
    with pytest.raises(VehicleError, match="has no currents; add 'current' to 'esc'"):
        build("scaled", load_vehicle("ukwial"))(np.ones(3), cap=20.0)


def test_a_method_that_takes_no_cap_refuses_it(entry: Entry) -> None:
    if entry.name in HONOUR:
        return
    vehicle = load_vehicle("ukwial" if entry.name.startswith("walsh") else "bluerov2-heavy")
    allocate = build(entry.name, vehicle)
    with pytest.raises(ValueError, match=r"cap: .* take none; use scaled"):
        allocate(np.ones(vehicle.k), cap=20.0)
    with pytest.raises(ValueError, match=r"cap: .* take none; use scaled"):
        allocate.many(np.ones((2, vehicle.k)), cap=20.0)
