"""The bound on rounding holds against numbers calculated exactly, and is no ten times what is seen."""

from fractions import Fraction

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.native.code import TOLERANCE
from alloc.native.compiled import compiler
from bench.prove import subject, tools
from bench.prove.band import verdict_band
from bench.prove.gappa import before_limits
from bench.prove.numeric import answered, answers, values
from bench.prove.program import NotRead
from bench.prove.rounding import Errors
from bench.prove.seen import seen
from bench.prove.symbolic import programs

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")


@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize(
    ("name", "kernel"), [("ukwial", "scaled"), ("bluerov2-heavy", "nullspace"), ("bluerov2", "shrink")]
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
        bound = max(errors.error(node) for (array, _), node in program.outputs.items() if array == "f")
        sample = seen(program, vehicle, of.scalar, {}, 20_000)
        assert sample.answered == sample.demands
        assert bound / 10 <= sample.error <= bound


def test_the_bound_holds_against_fractions() -> None:
    """Of the closed form, whose exact value fractions give without any rounding."""
    of = subject(load_vehicle("ukwial"), "pinv", "double", "fixed")
    program = programs(of)[-1]
    errors = Errors(program, of.vehicle, "double")
    rng = np.random.default_rng(3)
    f = rng.choice([of.vehicle.f_min, of.vehicle.f_max], 200)
    for tau in f @ of.vehicle.TP.T:
        got = answers(program, {"tau": tau[:, None]}, np.float64).outputs["f"][:, 0]
        exact: list[Fraction] = []
        for operation, *operands in program.nodes:
            values = [exact[each] for each in operands] if operation not in ("const", "input") else []
            match operation:
                case "const":
                    exact.append(Fraction(operands[0]))
                case "input":
                    exact.append(Fraction(float(tau[operands[1]])))
                case "neg":
                    exact.append(-values[0])
                case "add" | "sub" | "mul":
                    a, b = values
                    exact.append({"add": a + b, "sub": a - b, "mul": a * b}[operation])
                case _:  # of the status
                    exact.append(Fraction(0))
        for (_, i), node in program.outputs.items():
            assert abs(Fraction(float(got[i])) - exact[node]) <= Fraction(errors.error(node))


@pytest.mark.skipif("gappa" in tools.missing(), reason=f"needs gappa: {tools.remedy(['gappa'])}")
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_gappa_finds_a_bound_of_the_same_size(scalar: str) -> None:
    """Gappa's holds for a box around the attainable demands, so it is no smaller, and not much larger."""
    of = subject(load_vehicle("ukwial"), "pinv", scalar, "fixed")  # type: ignore[arg-type]
    program = programs(of)[-1]
    errors = Errors(program, of.vehicle, of.scalar)
    bound = max(errors.error(node) for node in program.outputs.values())
    gappa = before_limits(program, errors, of.vehicle, of.scalar)
    assert gappa is not None
    assert bound <= gappa <= 3 * bound


def test_shrink_has_no_place_where_rounding_decides() -> None:
    """It is continuous, so the bound is the same where branches may turn, and none ever does at a limit."""
    if np.finfo(np.longdouble).nmant <= 52:
        pytest.skip("numpy has nothing wider than double here to compare with")
    vehicle = load_vehicle("ukwial")
    program = programs(subject(vehicle, "shrink", "double", "fixed"))[-1]
    bound, turned = (
        max(each.error(node) for (name, _), node in program.outputs.items() if name == "f")
        for each in (Errors(program, vehicle, "double", flips=flips) for flips in (False, True))
    )
    assert bound == turned
    rng = np.random.default_rng(6)
    tau = vehicle.TP @ np.array([[250.0], [-125.0], [80.0], [-60.0]])
    closed = np.linalg.pinv(vehicle.TP) @ tau
    tau = tau * 250.0 / abs(closed).max() * (1 + rng.uniform(-2e-15, 2e-15, (3, 4000)))
    narrow, wide = (
        answered(program, values(program, {"tau": tau}, kind)).outputs["f"]
        for kind in (np.float64, np.longdouble)
    )
    assert np.abs(narrow - wide).max() <= bound


def test_a_verdict_differs_within_the_band_only() -> None:
    """Demands of alpha* = 1 - 2 band are refused, and those of 1 + 2 band answered, each one."""
    vehicle = load_vehicle("ukwial")
    program = programs(subject(vehicle, "nullspace", "double", "fixed"))[-1]
    band = verdict_band(program, Errors(program, vehicle, "double"), TOLERANCE["double"] * vehicle.f_scale)
    assert band is not None
    assert band < 1e-8
    corners = np.random.default_rng(5).choice([-1.0, 1.0], (500, vehicle.n)) * vehicle.f_max
    taus = corners @ vehicle.TP.T
    from alloc import alpha_max

    edge = taus * alpha_max(vehicle, taus)[:, None]
    for share, status in ((1.0 + 2.0 * band, 2), (1.0 - 2.0 * band, 0)):
        got = answers(program, {"tau": (share * edge).T}, np.float64).status
        assert set(got.tolist()) == {status}


def test_what_can_not_be_bounded_says_why() -> None:
    of = subject(load_vehicle("supply-vessel"), "nullspace", "double", "fixed")
    program = programs(of)[-1]
    with pytest.raises(NotRead, match="branch"):
        Errors(program, of.vehicle, "double").error(program.outputs["f", 0])
