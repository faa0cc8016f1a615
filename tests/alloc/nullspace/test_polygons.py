"""nullspace and scaled on thrusters that turn, held against facets, limits and multipliers."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, alpha_max, build
from alloc.nullspace.allocator import MOST_FREE
from alloc.reach.attainable import alpha_max_lp
from alloc.vehicle.azimuth import Azimuth, polygon_corners
from alloc.vehicle.names import Priority
from tests.azimuths import boats, corners_lp, demands_around, excess, stationarity
from tests.pages import blocks
from tests.places import DOCS

BOATS = boats(96, most=3)
SHARES = (0.02, 0.3, 0.8, 0.97, 1.0 - 1e-6, 1.0 + 1e-6, 1.02, 3.0)
"""Shares of alpha* that are asked for: inside, at the edge, beyond it."""
ROUNDING = 1e-14
"""Excess over a side that a product rounds away [-]."""
OPTIMAL = 1e-6


@cache
def covered() -> list[Vehicle]:
    """The boats that the method does not refuse: up to three dimensions, and not too many slabs."""
    taken = []
    for vehicle in BOATS:
        try:
            build("nullspace", vehicle)
        except NotApplicable:
            continue
        taken.append(vehicle)
    assert len(taken) >= 50
    return taken


def asked(vehicle: Vehicle, rng: np.random.Generator) -> list[tuple[np.ndarray, float]]:
    """Demands with their alpha*: two directions, each by SHARES of what is attainable."""
    taus = demands_around(vehicle, rng, 2)
    edge = alpha_max(vehicle, taus)
    return [
        (share * far * tau, 1.0 / share)
        for tau, far in zip(taus, edge, strict=True)
        if far > 1e-6
        for share in SHARES
    ]


def test_nullspace_gives_the_least_effort_within_the_polygons_or_says_that_there_is_none() -> None:
    rng, verdicts = np.random.default_rng(7), 0
    for vehicle in covered():
        allocate = build("nullspace", vehicle)
        for tau, alpha in asked(vehicle, rng):
            result = allocate(tau)
            verdicts += 1
            assert (result.status is Status.SOLVED) == (alpha > 1.0), (vehicle.name, alpha, result)
            if alpha < 1.0:
                assert result.status is Status.INFEASIBLE
                continue
            assert np.abs((vehicle.TP @ result.f - tau) / vehicle.wrench_scale).max() <= 1e-9
            assert excess(vehicle, result.f) <= ROUNDING
            assert stationarity(vehicle, result.f) <= OPTIMAL, (vehicle.name, alpha)
            assert result.iterations <= allocate.worst_case_steps * (5 if alpha < 1.1 else 1)
    assert verdicts > 1000


def test_scaled_goes_as_far_towards_each_demand_as_a_linear_program_over_corners_does() -> None:
    rng = np.random.default_rng(8)
    for vehicle in covered():
        allocate = build("scaled", vehicle)
        for tau, alpha in asked(vehicle, rng):
            result = allocate(tau)
            share = min(1.0, alpha)
            assert result.share == (pytest.approx(share, abs=1e-9),)
            assert result.status is (Status.SOLVED if alpha > 1.0 else Status.PARTIAL)
            assert np.abs((vehicle.TP @ result.f - share * tau) / vehicle.wrench_scale).max() <= 1e-8
            assert excess(vehicle, result.f) <= ROUNDING
            assert stationarity(vehicle, result.f) <= OPTIMAL
        for tau, alpha in asked(vehicle, rng)[::4]:
            assert corners_lp(vehicle, tau) == pytest.approx(alpha, rel=1e-8)


@pytest.mark.parametrize("levels", [(("yaw",), ("surge", "sway")), (("surge",), ("yaw",), ("sway",))])
def test_priority_goes_level_by_level_as_far_as_linear_programs_do(levels: Priority) -> None:
    rng, stopped = np.random.default_rng(11), 0
    for plain in covered()[::2]:
        vehicle = replace(plain, priority=levels)
        allocate = build("priority", vehicle)
        for tau in demands_around(vehicle, rng, 2) * rng.choice([0.1, 0.5, 2.0], (2, 1)):
            reached, shares = np.zeros(3), list[float]()
            for level in levels:
                step = np.array(
                    [x if axis in level else 0.0 for axis, x in zip(vehicle.dof, tau, strict=True)]
                )
                keep = 0.99 if level is not levels[-1] else 1.0
                shares.append(min(1.0, keep * alpha_max_lp(vehicle, step, start=reached)))
                reached += shares[-1] * step
            result = allocate(tau)
            stopped += min(shares) < 1.0
            assert result.share == pytest.approx(shares, abs=1e-7), vehicle.name
            assert np.abs((vehicle.TP @ result.f - reached) / vehicle.wrench_scale).max() <= 1e-7
            assert excess(vehicle, result.f) <= ROUNDING
            assert stationarity(vehicle, result.f) <= OPTIMAL
            assert result.status is (Status.SOLVED if min(shares) == 1.0 else Status.PARTIAL)
    assert stopped > 20


@pytest.mark.parametrize("method", ["nullspace", "scaled", "pinv", "priority"])
def test_many_calls_at_once_give_the_answers_of_single_ones(method: str) -> None:
    rng = np.random.default_rng(9)
    for vehicle in covered()[:24]:
        allocate = build(method, vehicle)
        taus = np.array([tau for tau, _ in asked(vehicle, rng)]).reshape(-1, 3)
        F, status = allocate.many(taus)
        for tau, f, given in zip(taus, F, status, strict=True):
            single = allocate(tau)
            assert single.status == given
            assert single.f == pytest.approx(f, rel=1e-9, abs=1e-9 * vehicle.f_scale, nan_ok=True)


def test_after_a_failure_the_others_go_on_within_their_polygons() -> None:
    rng, seen = np.random.default_rng(10), 0
    for vehicle in BOATS:
        for thruster in range(len(vehicle.actuators)):
            failed = vehicle.with_fault(thruster)
            if failed.rank < 3 or failed.nullity > MOST_FREE or seen > 60:
                continue
            try:
                allocate = build("nullspace", failed)
            except NotApplicable:
                continue
            seen += 1
            for tau, alpha in asked(failed, rng):
                result = allocate(tau)
                assert (result.status is Status.SOLVED) == (alpha > 1.0)
                if alpha > 1.0:
                    assert (result.f[list(vehicle.actuators[thruster])] == 0.0).all()
                    assert excess(failed, result.f) <= ROUNDING
                    assert stationarity(failed, result.f) <= OPTIMAL
    assert seen > 40


def test_a_null_space_of_too_many_dimensions_is_refused_in_words() -> None:
    large = next(vehicle for vehicle in BOATS if vehicle.nullity > MOST_FREE)
    with pytest.raises(NotApplicable, match=r"nullspace: .* leave d = \d and .* use a qp/ method"):
        build("nullspace", large)


def test_the_ferry_s_page_prints_what_the_ferry_does(capsys: pytest.CaptureFixture[str]) -> None:
    page = DOCS / "azimuth.md"
    (code,), (said, *_) = blocks(page, "python"), blocks(page, "")
    exec(code, {})
    assert capsys.readouterr().out == said


def test_a_polygon_loses_what_the_page_says() -> None:
    (said,) = re.findall(r"in its worst direction: (.*?)\. ", (DOCS / "azimuth.md").read_text())
    rows = re.findall(r"(\d+) (?:lose )?([\d.]+) %", said)
    for sides, percent in rows:
        disc = Azimuth(0, polygon_corners(1.0, (-180.0, 180.0), int(sides)))
        assert 100 * (1 - disc.reach.min()) == pytest.approx(float(percent), rel=0.03)
        assert len(disc.distinct) == int(sides) // 2
    assert len(rows) == 4
