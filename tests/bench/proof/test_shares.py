"""Thrusts that depend on shares of steps: the bound on rounding, its premises, and its failures."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.allocation import FloatArray
from alloc.c.compiled import compiler
from alloc.program import Program, Scalar, values
from bench.demands.corners import thrusts
from bench.proof import subject
from bench.proof.rounding import claims
from bench.proof.rounding.arithmetic import among
from bench.proof.rounding.errors import Errors
from bench.proof.rounding.products import NOTHING, ONE, Form, ProductSet, _Model, constant, total
from bench.proof.rounding.shares import shares
from bench.proof.symbolic import programs
from tests.bench.proof.in_fractions import exactly
from tests.bench.proof.search import largest_error

pytest.importorskip("highspy")
pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
OFF = 2
"""The thruster that is off: its programs are the smaller ones."""


def kernel(scalar: Scalar) -> tuple[Program, Vehicle]:
    """priority of a vehicle of three levels, the first two of which use up rooms of those behind them."""
    vehicle = load_vehicle("bluerov2")
    return programs(subject(vehicle, "priority", scalar, "fixed"))[OFF], vehicle.with_fault(OFF)


def bound(program: Program, vehicle: Vehicle, scalar: Scalar) -> float:
    """The bound of all thrusts [N]."""
    return Errors(program, vehicle, scalar).bound()


@pytest.mark.parametrize("scalar", ["double", "float"])
def test_the_largest_error_that_a_search_finds_is_a_tenth_of_the_bound_at_least(scalar: Scalar) -> None:
    """And no more than it; random demands come to a twentieth, since few of them leave little room."""
    if scalar == "double" and np.finfo(np.longdouble).nmant <= 52:
        pytest.skip("numpy has nothing wider than double here to compare with")
    program, vehicle = kernel(scalar)
    most = bound(program, vehicle, scalar)
    assert most / 10 <= largest_error(program, vehicle, scalar, most / 10) <= most


def test_the_bound_holds_against_fractions_where_little_room_is_left() -> None:
    """Demands whose first level leaves one per cent of a room, calculated without any rounding."""
    program, vehicle = kernel("double")
    errors = Errors(program, vehicle, "double")
    f = np.random.default_rng(4).uniform(-40.0, 40.0, (vehicle.n, 60))
    f[4:, :] = np.where(f[4:, :] > 0, 39.99, -39.99)  # both vertical thrusters
    near = 0
    for tau in (vehicle.TP @ f).T:
        got = values(program, {"tau": tau[:, None]}, np.float64)
        true = exactly(program, tau)
        near += bool(true[program.outputs["share", 1]] < 1)
        for (name, _), node in program.outputs.items():
            if name == "f":
                assert abs(Fraction(np.float64(got[node].item())) - true[node]) <= Fraction(
                    errors.error(node)
                )
    assert near > 10


def test_a_room_that_is_taken_for_larger_than_it_is_gives_a_bound_that_does_not_hold(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A level leaves one per cent of a room. Were it said to leave half, a search finds larger errors."""
    if np.finfo(np.longdouble).nmant <= 52:
        pytest.skip("numpy has nothing wider than double here to compare with")
    program, vehicle = kernel("double")
    known = ProductSet.add

    def too_much(self: ProductSet, fact: Form) -> None:
        known(self, {atom: (each / 2 if atom[0] == NOTHING else each) for atom, each in fact.items()})

    monkeypatch.setattr(ProductSet, "add", too_much)
    wrong = bound(program, vehicle, "double")
    assert largest_error(program, vehicle, "double", wrong) > wrong


def test_an_error_above_the_bound_is_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is seen stands against the bound."""
    monkeypatch.setattr(claims, "sample", lambda *_: claims.Sample(1.0, 0.0, 100, 100))
    claim, rows = claims.rounding_claim(
        subject(load_vehicle("ukwial"), "scaled", "double", "fixed"), 100, 100
    )
    assert claim.verdict == "not shown"
    assert "an error of 1 N was seen, above the bound" in claim.words[0]
    assert all(row.bound_n < 1e-11 for row in rows)


def test_in_float_no_rounding_draws_thrusts_in() -> None:
    """The check of thrusts against shares is never taken, so its bound is that without it, of all faults."""
    claim, rows = claims.rounding_claim(subject(load_vehicle("ukwial"), "scaled", "float", "fixed"), 100, 100)
    assert (claim.verdict, claim.words) == ("shown", [])
    assert [row.fault for row in rows] == [-1, 0, 1, 2, 3]
    assert all(row.flipped_n is None for row in rows)


def test_thrusts_in_float_go_no_further_beyond_limits_than_is_followed() -> None:
    """Attainable demands take them beyond by rounding alone, and by no more than its bound."""
    of = subject(load_vehicle("ukwial"), "scaled", "float", "fixed")
    program, exact = programs(of)[-1], claims.exact_constants(of)[-1]
    errors = Errors(program, of.vehicle, "float", exact, flips=True)
    asked = {program.nodes[each[1]] for each in program.nodes if each[0] == "choose"}
    ((_, worst, bound),) = [each for each in asked if each[0] == "gt"]
    limit = errors.values[bound].low
    most = max(errors._most(each) for each in among(errors.values[worst]))
    taus = (of.vehicle.TP @ thrusts(of.vehicle, np.random.default_rng(8), 20_000)).astype(np.float32)
    found = np.asarray(values(program, {"tau": taus}, np.float32)[worst])
    assert 0.0 < found.max() <= most < limit


def test_three_levels_have_three_shares_and_no_other_division_is_one() -> None:
    program, _ = kernel("double")
    assert len(shares(program.nodes)) == 3
    assert not shares([("div", 0, 1) if each[0] == "div" else each for each in program.nodes])


def test_no_demand_and_share_exceeds_what_a_linear_program_says() -> None:
    """Terms p tau_j, tau_j and p, with the fact that p tau_0 is at most 1; the largest is just that."""
    vehicle = load_vehicle("ukwial")
    products, p = ProductSet(vehicle, 0.0), 7
    alone = {(NOTHING, 0): 1.0}
    largest = float(np.abs(vehicle.TP[0]) @ vehicle.f_max)
    assert products.most(alone) == pytest.approx(largest, rel=1e-6)
    taken: Form = {(frozenset({p}), 0): 1.0}
    products.add(total((1.0, constant(1.0)), (-1.0, taken)))
    assert products.most(taken) == pytest.approx(1.0, rel=1e-6)
    rng = np.random.default_rng(8)
    tau = vehicle.TP @ rng.choice([-1.0, 1.0], (vehicle.n, 500)) * vehicle.f_max[0]
    share = np.minimum(1.0, 1.0 / np.maximum(tau[0], 1e-9)) * rng.random(500)
    for _ in range(20):
        a, b, c, d = rng.standard_normal(4)
        form: Form = {(frozenset({p}), 0): a, (frozenset({p}), 1): b, (NOTHING, 1): c}
        form[frozenset({p}), ONE] = d
        seen = share * (a * tau[0] + b * tau[1] + d) + c * tau[1]
        assert products.least(form) <= seen.min() <= seen.max() <= products.most(form)


def test_a_solver_that_is_wrong_gives_no_bound_that_is_too_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """The multipliers are the proof; with others, or none, the bound is wider."""
    vehicle = load_vehicle("ukwial")
    form = {(NOTHING, 0): 1.0}
    true = ProductSet(vehicle, 0.0).most(form)
    solve = _Model.largest

    def wrong(self: _Model, objective: FloatArray, below: FloatArray) -> Any:
        found = solve(self, objective, below)
        assert found is not None
        return found[0] / 2, found[1]

    monkeypatch.setattr(_Model, "largest", wrong)
    assert ProductSet(vehicle, 0.0).most(form) >= 0.999 * true
