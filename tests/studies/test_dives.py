"""The study of failures that nobody announces, on few dives; docs/failures.md has the large one."""

import numpy as np
import pytest

from alloc import load_vehicle
from dives import body, fly, of_vehicle, separable, sole_failures


def test_a_row_names_dead_thrusters_and_accuses_no_healthy_one() -> None:
    name, inside, near, told, named, suspect, _, wrongly, _ = of_vehicle("ukwial", 4)
    assert (name, told, named, suspect, wrongly) == ("ukwial", "4 of 4", "100.0", "100.0", "0, 0")
    assert float(inside) >= 80.0  # of 16
    assert float(near) == 100.0


def test_only_failures_that_can_be_told_apart_are_flown() -> None:
    vessel = load_vehicle("supply-vessel")
    readiness, off = sole_failures(vessel, separable(vessel), 6)
    assert set(off) == {4, 5}
    assert ((readiness == 0.0).sum(axis=1) == 1).all()


def test_a_dive_follows_the_equations_of_motion() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    flight = fly(vehicle, np.random.default_rng(1), np.ones((2, 8)), 5.0, noise=0.0, current=0.2)
    became = np.diff(flight.v, axis=1) / np.diff(flight.t)[:, None]
    off = np.abs(became - flight.a[:, :-1]).mean(axis=(0, 1)) / np.abs(flight.a).mean(axis=(0, 1))
    assert (off < 0.2).all()  # what rates of change do within a row
    assert body(vehicle) == pytest.approx(np.ones(6))
