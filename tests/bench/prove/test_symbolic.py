"""The C as a list of operations answers as the compiled C does, and its limits follow from the comparison."""

import ctypes

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.native.compiled import compiler, shared_library
from bench.prove import subject
from bench.prove.limits import within
from bench.prove.numeric import answers
from bench.prove.sabotage import SABOTAGES, Sabotage, sabotaged
from bench.prove.symbolic import NotRead, programs

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
        read = answers(programs(of)[fault], {"tau": taus.T}, kind)
        for i, tau in enumerate(taus):
            thrusts, share = np.zeros(vehicle.n, kind), np.zeros(9, kind)
            arrays = [thrusts, share] if of.levels else [thrusts]
            status = function(tau.ctypes, fault, *(array.ctypes for array in arrays))
            assert status == read.status[i]
            if status in (0, 1):
                np.testing.assert_array_equal(thrusts, read.outputs["f"][:, i])


@pytest.mark.parametrize("kernel", ["nullspace", "clip", "scaled", "redistribute"])
def test_limits_of_the_call_follow_from_the_comparison_that_answers(kernel: str) -> None:
    of = subject(load_vehicle("bluerov2-heavy"), kernel, "float", "call")
    for fault, program in programs(of).items():
        assert within(program, fault, of.vehicle.n) == []


@pytest.mark.parametrize(
    "sabotage", [each for each in SABOTAGES if each.limits == "call"], ids=lambda each: each.name
)
def test_they_do_not_where_the_comparison_or_the_cut_is_broken(sabotage: Sabotage) -> None:
    of = sabotaged(subject(UKWIAL, sabotage.kernel, "double", "call"), sabotage)
    assert within(programs(of)[-1], -1, of.vehicle.n)


def test_what_is_not_straight_code_is_refused() -> None:
    """A number that is calculated has no place as an index, and the message says so."""
    sabotage = Sabotage("an index", "nullspace", "fixed", r"= tau\[0\]", "= tau[(int)tau[1]]")
    with pytest.raises(NotRead, match="index"):
        programs(sabotaged(subject(UKWIAL, "nullspace", "double", "fixed"), sabotage))
