"""A peer's harness on our problems: qpbenchmark runs them and agrees with us on what is solved."""

import importlib
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("qpbenchmark", reason="extra qpbenchmark is not installed")
from qpbenchmark.benchmark import load_test_set

from alloc import build
from bench.studies.cross_check import ours, theirs
from bench.studies.thrust_allocation import ThrustAllocation, cases

FILE = Path(importlib.import_module("bench.studies.thrust_allocation").__file__ or "")


@pytest.fixture(scope="module")
def handful() -> ThrustAllocation:
    return ThrustAllocation(vehicles=("ukwial", "bluerov2-heavy"), each=2)


def test_qpbenchmark_finds_the_test_set_by_its_file() -> None:
    found = load_test_set(str(FILE))
    assert found.title == "Thrust allocation test set"
    assert found.count_problems() == 60  # six vehicles, two regimes, five demands


def test_each_problem_is_eq_4_and_5_of_its_vehicle(handful: ThrustAllocation) -> None:
    """The exact answer, put into qpbenchmark's problem, is feasible there and meets its equations."""
    for problem, (_, vehicle, tau) in zip(handful, handful.cases, strict=True):
        x = build("nullspace", vehicle)(tau).f / vehicle.f_scale
        np.testing.assert_allclose(problem.A @ x, problem.b, rtol=0, atol=1e-12)
        assert (x >= problem.lb).all()
        assert (x <= problem.ub).all()


def test_both_harnesses_call_daqp_s_answers_good(handful: ThrustAllocation) -> None:
    frame = theirs(handful, ("high_accuracy",), solver="daqp").df
    assert len(frame) == len(handful.cases) == 8
    assert frame["found"].all()
    assert (frame[["primal_residual", "dual_residual", "duality_gap"]].to_numpy() < 1e-9).all()
    for route in ("qp/daqp", "qpsolvers/daqp"):
        assert ours(route, handful.cases).right == 1.0


def test_cases_are_the_same_each_time() -> None:
    for one, other in zip(cases(("ukwial",), 3), cases(("ukwial",), 3), strict=True):
        assert one.name == other.name
        np.testing.assert_array_equal(one.tau, other.tau)
