"""Summary of many answers; a user's answers are those of single calls."""

import numpy as np
import pytest

from alloc import Allocation, Allocator, build, load_vehicle
from alloc.allocation import FloatArray, StatusArray
from bench.demands import build_demands
from bench.demands.store import Case
from bench.harness.worker import answer_case

VEHICLE = load_vehicle("ukwial")
CASE = Case(VEHICLE, build_demands("active", VEHICLE, 1, 200).taus)


class Two:
    """An allocator whose calls are one method's and whose ``many`` is another's."""

    formulation, limited, tolerance = "mine", True, 1.0

    def __init__(self, calls: str, many: str) -> None:
        self.calls, self.all = build(calls, VEHICLE), build(many, VEHICLE)

    def __call__(
        self, tau: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
    ) -> Allocation:
        """As the one method does."""
        return self.calls(tau, f_min, f_max)

    def many(
        self, taus: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """As the other does."""
        return self.all.many(taus, f_min, f_max)


def test_thrusts_of_many_that_calls_do_not_give_are_no_answers() -> None:
    """A report said that a method serves all of which each call was clipped."""
    with pytest.raises(ValueError, match=r"many\(\) gives demand \d+ other thrusts than a call of its own"):
        answer_case(Two("clip", "nullspace"), CASE, brought=True)
    F, status = answer_case(Two("clip", "clip"), CASE, brought=True)
    np.testing.assert_array_equal(F, build("clip", VEHICLE).many(CASE.taus)[0])
    assert status.tolist() == build("clip", VEHICLE).many(CASE.taus)[1].tolist()


def test_limits_of_each_demand_are_those_of_its_call_too() -> None:
    demands = build_demands("jolts", VEHICLE, 1, 60)
    case = Case(VEHICLE, demands.taus, demands.f_min, demands.f_max)
    F, _ = answer_case(Two("scaled", "scaled"), case, brought=True)
    answered = np.isfinite(F).all(axis=1)
    assert answered.sum() > 30
    assert (demands.limits[1] >= F)[answered].all()


@pytest.mark.parametrize("method", ["qp/osqp", "qp/proxqp"])
def test_a_solver_that_goes_on_from_its_last_answer_may_come_elsewhere(method: str) -> None:
    allocator: Allocator = build(method, VEHICLE, start="warm")
    F, _ = answer_case(allocator, CASE, brought=True)
    assert F.shape == (200, 4)
