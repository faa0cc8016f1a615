"""The C as a list of operations answers as the compiled C does, and its limits follow from the comparison."""

import ctypes
from dataclasses import replace

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.c import covering
from alloc.c.compiled import compiler, shared_library
from alloc.program import Faults, answered, values
from bench.proof import subject
from bench.proof.safety.claims import limit_gaps, rest_gaps
from bench.proof.source import NotRead
from bench.proof.symbolic import programs
from sabotages import SABOTAGES, Sabotage, sabotaged

pytestmark = pytest.mark.skipif(not compiler(), reason="needs a C compiler")
UKWIAL = load_vehicle("ukwial")
SCALARS = {"double": np.float64, "float": np.float32}


@pytest.mark.parametrize(
    ("name", "kernel", "scalar"),
    [
        ("ukwial", "nullspace", "double"),
        ("ukwial", "scaled", "float"),
        ("ukwial", "shrink", "double"),
        ("supply-vessel", "nullspace", "double"),
    ],
)
def test_the_operations_are_those_of_the_compiled_c(name: str, kernel: str, scalar: str) -> None:
    """Status and thrusts are equal to the last bit, inside and outside, with and without a fault."""
    vehicle = load_vehicle(name)
    of = subject(vehicle, kernel, scalar, "fixed")  # type: ignore[arg-type]  # pytest's parameters are text
    kind = SCALARS[scalar]
    function = ctypes.CDLL(str(shared_library("proof", of.files)))[of.name]
    rng = np.random.default_rng(1)
    f = rng.uniform(1.5 * vehicle.f_min, 1.5 * vehicle.f_max, (60, vehicle.n))
    taus = np.ascontiguousarray((f @ vehicle.TP.T).astype(kind))
    taus[0], taus[1] = np.nan, np.finfo(kind).max
    for fault in (-1, 1):
        program = programs(of)[fault]
        read = answered(program, values(program, {"tau": taus.T}, kind), len(taus))
        for i, tau in enumerate(taus):
            thrusts, share = np.zeros(vehicle.n, kind), np.zeros(9, kind)
            arrays = [thrusts, share] if of.levels else [thrusts]
            status = function(tau.ctypes, fault, *(array.ctypes for array in arrays))
            assert status == read.status[i]
            if status in (0, 1):
                np.testing.assert_array_equal(thrusts, read.F[i])


@pytest.mark.parametrize(
    ("kernel", "faults"),
    [("nullspace", "one"), ("clip", "one"), ("scaled", "one"), ("redistribute", "one"), ("scaled", "all")],
)
def test_limits_of_the_call_follow_from_the_comparison_that_answers(kernel: str, faults: Faults) -> None:
    of = subject(load_vehicle("bluerov2-heavy"), kernel, "float", "call", faults)
    for fault, program in programs(of).items():
        assert limit_gaps(program, fault, of.vehicle.n) == []


def test_a_thruster_that_is_off_and_keeps_its_limits_is_told() -> None:
    of = subject(UKWIAL, "nullspace", "double", "call", "all")
    kept = of.source.replace("high[off] = 0.0;", "")
    assert kept != of.source
    broken = replace(of, files={**of.files, f"{of.name}.c": kept})
    assert limit_gaps(programs(broken)[2], 2, UKWIAL.n)


@pytest.mark.parametrize("kernel", ["clip", "shrink"])
def test_a_thruster_that_is_off_rests(kernel: str) -> None:
    """Its thrust is x - 1 off, where off is 1 x and no part of others."""
    for fault, program in programs(subject(UKWIAL, kernel, "double", "fixed", "all")).items():
        assert rest_gaps(program, fault) == []


@pytest.mark.parametrize(
    ("printed", "broken"),
    [
        ("x1 - of[5] * off", "x1 - of[4] * off"),
        ("x1 - of[5] * off", "x1 + of[5] * off"),
        ("of[1] * x1", "of[1] * x2"),
        ("nan_or_zero = xo0 - xo0", "nan_or_zero = 0.0"),
        ("tb_within(xo1, -c[3], c[3])", "tb_within(xo1, c[3], c[3])"),
        ("return TB_NOT_FINITE;", "return TB_SOLVED;"),
    ],
)
def test_a_thruster_that_is_off_and_may_not_rest_is_told(printed: str, broken: str) -> None:
    """Another share is taken, or an infinite value is answered: x - x is NaN then."""
    of = subject(UKWIAL, "clip", "double", "fixed", "all")
    assert of.source.count(printed) == 1
    changed = of.source.replace(printed, broken)
    made = programs(replace(of, files={**of.files, f"{of.name}.c": changed}))
    assert rest_gaps(made[1], 1)


@pytest.mark.parametrize(
    "sabotage",
    [each for each in SABOTAGES if each.change and each.limits == "call"],
    ids=lambda each: each.name,
)
def test_they_do_not_where_the_comparison_or_the_cut_is_broken(sabotage: Sabotage) -> None:
    of = sabotaged(subject(UKWIAL, sabotage.kernel, "double", "call"), sabotage)
    assert limit_gaps(programs(of)[-1], -1, of.vehicle.n)


ODD = (np.nan, -np.inf, np.inf, 0.0, -0.0, 1.0, -2.0, 5e-324, -1.7e308)


def test_minimum_and_maximum_for_the_analyser_cover_both_forms() -> None:
    """With ``either`` 0 it is the C's own, with 1 IEEE 754's minNum and maxNum, zeros' signs apart.

    So whatever the analyser shows of its copy holds of comparisons and of the FPU's instructions.
    """
    source = subject(UKWIAL, "nullspace", "double", "fixed").source
    helpers = source[source.index("#ifndef TB_LEAST\n") : source.index("#ifndef TB_WITHIN\n")]
    called = "".join(
        f"double call_{f}(double a, double b) {{ return tb_{f}(a, b); }}\n" for f in ("least", "most")
    )
    own = ctypes.CDLL(str(shared_library("own", {"own.c": helpers + called})))
    text = "volatile int either;\n" + covering(helpers, "double") + called
    copy = ctypes.CDLL(str(shared_library("copy", {"copy.c": text})))
    either = ctypes.c_int.in_dll(copy, "either")
    for name, ieee in (("least", np.fmin), ("most", np.fmax)):
        ours, theirs = (getattr(library, f"call_{name}") for library in (own, copy))
        ours.restype = theirs.restype = ctypes.c_double
        for a in map(ctypes.c_double, ODD):
            for b in map(ctypes.c_double, ODD):
                either.value = 0
                np.testing.assert_equal(theirs(a, b), ours(a, b))
                either.value = 1
                np.testing.assert_array_equal(theirs(a, b), ieee(a.value, b.value))


def test_what_is_not_straight_code_is_refused() -> None:
    """A number that is calculated has no place as an index, and the message says so."""
    sabotage = Sabotage("an index", "nullspace", "fixed", r"= tau\[0\]", "= tau[tau[1] > 0.0]")
    with pytest.raises(NotRead, match="index"):
        programs(sabotaged(subject(UKWIAL, "nullspace", "double", "fixed"), sabotage))
