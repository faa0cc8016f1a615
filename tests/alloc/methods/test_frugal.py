"""`frugal`: no thrusts make the wrench, or more of it under a cap, by a program that is written otherwise."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from alloc import Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.current import Draw, PowerLaw

HEAVY = load_vehicle("bluerov2-heavy")
CASES = {
    "a table": HEAVY,
    "T without full rank": load_vehicle("bluerov2"),
    "one off": HEAVY.with_fault(1),
    "two off, a weak axis": HEAVY.with_fault(4).with_fault(5),
}


def calls(vehicle: Vehicle, rng: np.random.Generator, n: int) -> Iterator[tuple[FloatArray, float, float]]:
    """Demands up to twice as large as thrusters make, caps [A] and voltages [V]."""
    for _ in range(n):
        F = rng.uniform(vehicle.f_min, vehicle.f_max)
        yield rng.uniform(0.1, 2.0) * vehicle.TP @ F, rng.choice([3.0, 20.0, 90.0]), rng.uniform(10, 20)


def epigraph(vehicle: Vehicle, draw: Draw, wrench: FloatArray, cap: float | None) -> tuple[float, FloatArray]:
    """Least current of a wrench, or its largest share under a cap; currents lie above the curves' lines."""
    n, rows, most = vehicle.n, [], []
    for curve, columns in draw.groups:
        pieces = curve.pieces(-1.0, 1.0)
        for i in columns:
            for f, amps, slope in zip(pieces.f, pieces.amps, pieces.slopes, strict=False):
                rows.append(np.concatenate([slope * np.eye(n)[i], -np.eye(n)[i], [0.0]]))
                most.append(slope * f - amps)
    if cap is not None:
        rows.append(np.concatenate([np.zeros(n), np.ones(n), [0.0]]))
        most.append(cap)
    best = linprog(
        np.concatenate([np.zeros(n), np.full(n, float(cap is None)), [-float(cap is not None)]]),
        A_ub=np.array(rows),
        b_ub=most,
        A_eq=np.hstack([vehicle.strong.TP, np.zeros((vehicle.k, n)), -wrench[:, None]]),
        b_eq=np.zeros(vehicle.k),
        bounds=[
            *zip(vehicle.f_min, vehicle.f_max, strict=True),
            *[(None, None)] * n,
            (float(cap is None), 1.0),
        ],
    )
    assert best.x is not None
    return (float(best.fun) if cap is None else float(best.x[-1])), best.x[:n]


@pytest.mark.parametrize("case", CASES)
def test_no_other_thrusts_make_more_under_the_cap_or_the_same_for_less(
    case: str, rng: np.random.Generator
) -> None:
    vehicle, stopped = CASES[case], 0
    frugal, scaled = build("frugal", vehicle), build("scaled", vehicle)
    for tau, cap, volts in calls(vehicle, rng, 8):
        draw = vehicle.draw(volts)
        whole, least = scaled(tau), frugal(tau, volts=volts)
        made = vehicle.strong.TP @ whole.f
        assert least.share == pytest.approx(whole.share)
        assert np.sum(least.amps) == pytest.approx(epigraph(vehicle, draw, made, None)[0], abs=1e-6)
        np.testing.assert_allclose(vehicle.strong.TP @ least.f, made, atol=1e-6)
        found = frugal(tau, cap=cap, volts=volts)
        assert np.sum(found.amps) <= cap
        assert found.share[0] >= scaled(tau, cap=cap, volts=volts).share[0] - 1e-9
        part, _ = epigraph(vehicle, draw, made, cap)
        assert found.share[0] == pytest.approx(part * whole.share[0], abs=1e-6)
        stopped += found.status == Status.PARTIAL
    assert stopped > 2


def test_a_law_s_pieces_cost_a_thousandth_of_the_share_and_its_sum_stays_below_the_cap(
    rng: np.random.Generator,
) -> None:
    law = replace(HEAVY.esc[0], current=PowerLaw(0.076, 0.11, 1.5))
    vehicle = replace(HEAVY, esc=(law,) * 8)
    frugal, scaled = build("frugal", vehicle), build("scaled", vehicle)
    for tau, cap, _ in calls(vehicle, rng, 6):
        found, known = frugal(tau, cap=cap), scaled(tau, cap=cap)
        assert np.sum(found.amps) <= cap
        assert found.share[0] >= known.share[0] - 1e-3


def test_without_currents_thrusts_are_those_of_the_least_sum_of_powers(rng: np.random.Generator) -> None:
    vehicle = load_vehicle("ukwial")
    tau = vehicle.TP @ rng.uniform(vehicle.f_min, vehicle.f_max)
    found, least_effort = build("frugal", vehicle)(tau), build("nullspace", vehicle)(tau)
    assert found.amps == ()
    assert (np.abs(found.f) ** 1.5).sum() <= (np.abs(least_effort.f) ** 1.5).sum()


def test_a_cap_that_rest_exceeds_is_infeasible() -> None:
    vehicle = replace(HEAVY, f_min=np.full(8, 1.0))
    refused = build("frugal", vehicle)(vehicle.TP @ np.full(8, 20.0), cap=0.1, volts=12.0)
    assert refused.status == Status.INFEASIBLE
    assert np.isnan(refused.f).all()
