"""Bounds below a cap against the linear programs that they stand for."""

from dataclasses import replace

import numpy as np
import pytest

import fresh_demands
from alloc import Vehicle, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.current import Cap, PowerLaw
from bench.judging.cap import LARGEST, WAYS, compare_ways
from bench.judging.capability import even_demands

CAP = Cap(most=20.0, volts=12.0)
LAW = PowerLaw(ahead=0.076, astern=0.11, power=1.5)


def capped(name: str, law: PowerLaw | None = None, cap: Cap = CAP) -> Vehicle:
    vehicle = load_vehicle(name)
    escs = vehicle.esc if law is None else tuple(replace(esc, current=law) for esc in vehicle.esc)
    return replace(vehicle, cap=cap, esc=escs)


@pytest.mark.parametrize(
    "vehicle",
    [
        capped("bluerov2"),
        capped("nautilus"),
        capped("bluerov2", LAW),
        capped("bluerov2", cap=Cap(70, volts=12)),
    ],
    ids=["tables", "rank below n by two", "a law", "limits before the cap"],
)
def test_bounds_are_kept_by_every_answer_and_are_near(vehicle: Vehicle) -> None:
    taus = even_demands(vehicle, 1, 40)
    for way, (shares, currents) in compare_ways(vehicle, taus).items():
        least, most = fresh_demands.way_bounds(vehicle, way, taus)
        assert (least <= shares + 1e-9).all()
        assert (currents <= most + 1e-9).all()
        assert np.median(shares - least) < 0.05
        assert np.median(most - currents) < 0.05


def test_bounds_of_the_largest_share_leave_nothing_between() -> None:
    vehicle = capped("bluerov2-heavy")
    taus = even_demands(vehicle, 1, 20)
    limits, draw = vehicle.esc_limits(12.0), vehicle.draw(12.0)
    F = answers(vehicle, taus)
    shares, currents = fresh_demands.Capped(vehicle, limits, draw, 20.0).bounds(F, F)
    assert np.allclose(shares, 1.0, atol=1e-8)
    assert np.allclose(currents, 1.0, atol=1e-8)


def answers(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    asked = fresh_demands.stretch_demands(vehicle, taus)
    return fresh_demands.build(WAYS[LARGEST], vehicle).many(asked, cap=20.0, volts=12.0)[0]
