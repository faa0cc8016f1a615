"""The study of failures that nobody announces, on few dives; docs/failures.md has the large one."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.c import missing
from alloc.lint.isolation import assumed_noise
from bench.demands.mission import M
from dives import (
    CURRENT,
    GAIN,
    body,
    draws,
    fly,
    healthy_dive,
    healthy_odds,
    of_vehicle,
    separable,
    sole_failures,
)

needs_compiler = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


@needs_compiler
def test_a_row_names_dead_thrusters_and_accuses_no_healthy_one() -> None:
    name, known, inside, near, apart, named, suspect, *_, wrongly, cried, _ = of_vehicle("ukwial", 4, 0.1)
    assert (name, known, apart, named, suspect, wrongly) == (
        "ukwial",
        "100.0",
        "4 of 4",
        "100.0",
        "100.0",
        "0",
    )
    assert float(inside) >= 80.0  # of 16
    assert near == "100.0"
    assert cried == "0 in 0 h"


@needs_compiler
@pytest.mark.parametrize("name", ["ukwial", "bluerov2-heavy"])
def test_a_dive_in_c_is_that_in_python(name: str) -> None:
    plain = load_vehicle(name)
    size, drawn = body(plain), draws(plain, np.random.default_rng(3), 1, CURRENT)
    vehicle = replace(plain, inertia=size * M)
    flight = fly(vehicle, np.random.default_rng(3), np.ones((1, plain.n)), 10.0, 0.0, CURRENT, size, GAIN)
    rows = tuple(np.zeros_like(each[0]) for each in flight[1:])
    dive = healthy_dive(vehicle, assumed_noise(vehicle), size)
    dive(*(each.reshape(-1, plain.k) for each in drawn), 0.0, len(flight.t), 1, rows=rows)
    for row, each in zip(rows, flight[1:], strict=True):
        assert row == pytest.approx(each[0], abs=1e-9 * np.abs(row).max())


@needs_compiler
def test_healthy_dives_in_c_accuse_where_noise_is_stated_too_small() -> None:
    plain = load_vehicle("ukwial")
    size, rng = body(plain), np.random.default_rng(4)
    vehicle = replace(plain, inertia=size * M)
    noise = assumed_noise(vehicle)
    few, many = (healthy_odds(vehicle, factor * noise, size, 3, rng).max() for factor in (1.0, 0.01))
    assert few < 20.0 < many


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
