"""qpbenchmark's harness on our problems: it runs them and agrees on what is solved."""

import importlib
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("qpbenchmark", reason="extra qpbenchmark is not installed")
from qpbenchmark.benchmark import load_test_set

from alloc import build, list_vehicles
from cross_check import ours, theirs
from thrust_allocation import ThrustAllocation, cases

FILE = Path(importlib.import_module("thrust_allocation").__file__ or "")


@pytest.fixture(scope="module")
def handful() -> ThrustAllocation:
    return ThrustAllocation(vehicles=("ukwial", "bluerov2-heavy"), each=2)


def test_qpbenchmark_finds_the_test_set_by_its_file() -> None:
    test_set = load_test_set(str(FILE))
    assert test_set.title == "Thrust allocation test set"
    assert test_set.count_problems() == len(list_vehicles()) * 2 * 5  # regimes, demands


def test_each_problem_is_eq_4_and_5_of_its_vehicle(handful: ThrustAllocation) -> None:
    """The exact answer is feasible in qpbenchmark's problem and meets its equations."""
    for problem, (_, vehicle, tau) in zip(handful, handful.cases, strict=True):
        x = build("nullspace", vehicle)(tau).f / vehicle.f_scale
        np.testing.assert_allclose(problem.A @ x, problem.b, rtol=0, atol=1e-12)
        assert (x >= problem.lb).all()
        assert (x <= problem.ub).all()


def test_both_harnesses_find_daqp_s_answers_right(handful: ThrustAllocation) -> None:
    frame = theirs(handful, ("high_accuracy",), solver="daqp").df
    assert len(frame) == len(handful.cases) == 8
    assert frame["found"].all()
    assert (frame[["primal_residual", "dual_residual", "duality_gap"]].to_numpy() < 1e-9).all()
    for route in ("qp/daqp", "qpsolvers/daqp"):
        assert ours(route, handful.cases).right == 1.0


def test_cases_are_the_same_each_time() -> None:
    for first, second in zip(cases(("ukwial",), 3), cases(("ukwial",), 3), strict=True):
        assert first.name == second.name
        np.testing.assert_array_equal(first.tau, second.tau)
