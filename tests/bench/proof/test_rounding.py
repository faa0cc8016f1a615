"""The bound on rounding holds against numbers calculated exactly, and is no ten times what is seen."""

from fractions import Fraction

import numpy as np
import pytest

from alloc import Status, load_vehicle
from alloc.c.compiled import compiler
from alloc.program import Builder, alike, answered, evaluate, select, values
from bench.demands.corners import attainable
from bench.proof import subject
from bench.proof.rounding.claims import sample, verdict_band
from bench.proof.rounding.errors import Errors
from bench.proof.source import NotRead
from bench.proof.symbolic import programs
from tests.bench.proof.in_fractions import exactly

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")


@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize(
    ("name", "kernel"),
    [
        ("ukwial", "pinv"),
        ("ukwial", "scaled"),
        ("bluerov2-heavy", "nullspace"),
        ("bluerov2", "shrink"),
    ],
)
def test_the_bound_holds_and_is_not_far_off(name: str, kernel: str, scalar: str) -> None:
    """The largest of 20,000 errors is between a tenth of the bound and all of it, whole and with a fault.

    A million demands come nearer to the bound; their numbers stand in docs/proof.md.
    """
    if scalar == "double" and np.finfo(np.longdouble).nmant <= 52:
        pytest.skip("numpy has nothing wider than double here to compare with")
    of = subject(load_vehicle(name), kernel, scalar, "fixed")  # type: ignore[arg-type]
    for fault in (-1, 2):
        vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
        program = programs(of)[fault]
        errors = Errors(program, vehicle, of.scalar)
        bound = errors.bound()
        found = sample(program, vehicle, of.scalar, {}, 20_000)
        assert found.answered == found.demands
        assert bound / 10 <= found.error <= bound


def test_the_bound_holds_against_fractions() -> None:
    """Bounds for the closed form, whose exact value fractions give without any rounding."""
    of = subject(load_vehicle("ukwial"), "pinv", "double", "fixed")
    program = programs(of)[-1]
    errors = Errors(program, of.vehicle, "double")
    rng = np.random.default_rng(3)
    for tau in attainable(of.vehicle, rng, 200).T:
        got = evaluate(program, tau[None]).F[0]
        exact = exactly(program, tau)
        for (_, i), node in program.outputs.items():
            assert abs(Fraction(float(got[i])) - exact[node]) <= Fraction(errors.error(node))


def test_where_rounding_turns_a_branch_the_wider_bound_holds() -> None:
    """A thrust of 0.3 surge + 0.7 sway that halves above 100 N: there a last bit decides.

    Demands within some last bits of that place are answered in both ways; they are off by more than rounding
    alone, and by no more than the bound with branches turned.
    """
    if np.finfo(np.longdouble).nmant <= 52:
        pytest.skip("numpy has nothing wider than double here to compare with")
    builder = Builder(vehicle := load_vehicle("ukwial"))
    x = 0.3 * builder.tau[0] + 0.7 * builder.tau[1]
    program = builder.program([select(x > 100.0, 0.5 * x, x)], Status.SOLVED)
    bound, turned = (
        Errors(program, vehicle, "double", flips=flips).error(program.outputs["f", 0])
        for flips in (False, True)
    )
    surge = np.random.default_rng(6).uniform(-200.0, 200.0, 4000)
    taus = np.stack([surge, (100.0 - 0.3 * surge) / 0.7])
    narrow, wide = (values(program, {"tau": taus}, kind) for kind in (np.float64, np.longdouble))
    turns = ~alike(program, narrow, wide)
    assert 0 < turns.sum() < len(turns)
    off = np.abs(answered(program, narrow, 4000).F - answered(program, wide, 4000).F).max(axis=1)
    assert off[~turns].max() <= bound < 1e-12
    assert 49.0 < off[turns].max() <= turned


def test_where_what_a_branch_lessens_has_no_bound_the_reason_is_given() -> None:
    builder = Builder(vehicle := load_vehicle("ukwial"))
    surge, sway = builder.tau[:2]
    other = surge / sway
    program = builder.program([select(surge > 1.0, other - surge, other)], Status.SOLVED)
    with pytest.raises(NotRead, match="a division by what may be zero"):
        Errors(program, vehicle, "double").bound()


def test_a_verdict_differs_within_the_band_only() -> None:
    """Demands of alpha* = 1 - 2 band are refused, and those of 1 + 2 band answered, each one."""
    vehicle = load_vehicle("ukwial")
    program = programs(subject(vehicle, "nullspace", "double", "fixed"))[-1]
    band = verdict_band(program, Errors(program, vehicle, "double"), vehicle, "double")
    assert band is not None
    assert band < 1e-8
    corners = np.random.default_rng(5).choice([-1.0, 1.0], (500, vehicle.n)) * vehicle.f_max
    taus = corners @ vehicle.TP.T
    from alloc import alpha_max

    edge = taus * alpha_max(vehicle, taus)[:, None]
    for share, status in ((1.0 + 2.0 * band, 2), (1.0 - 2.0 * band, 0)):
        got = evaluate(program, share * edge).status
        assert set(got.tolist()) == {status}


def test_what_can_not_be_bounded_says_why() -> None:
    of = subject(load_vehicle("supply-vessel"), "nullspace", "double", "fixed")
    program = programs(of)[-1]
    with pytest.raises(NotRead, match="branch"):
        Errors(program, of.vehicle, "double").error(program.outputs["f", 0])
