"""The distance of soft thrusts to their optimum, found within the call, against a solver's optimum."""

import numpy as np
import pytest

from alloc import Status, alpha_max, build, load_vehicle
from alloc.qp import pose_soft
from alloc.qp.certificate import Stationarity
from alloc.solvers import Answer

VEHICLES = ("ukwial", "bluerov2-heavy", "supply-vessel")


@pytest.fixture(params=VEHICLES)
def case(request: pytest.FixtureRequest, rng: np.random.Generator):
    """A vehicle, its soft problem, and demands on both sides of what it can do."""
    vehicle = load_vehicle(request.param)
    taus = rng.normal(size=(30, vehicle.k)) * vehicle.wrench_scale
    taus *= (rng.choice([0.3, 0.9, 2.0], 30) * alpha_max(vehicle, taus))[:, None]
    return vehicle, pose_soft(vehicle), taus


def problem(case):
    vehicle, posed, taus = case
    F, _ = build("qp-soft/quadprog", vehicle).many(taus)
    assert not np.isnan(F).any()
    B, X = posed.scaled(taus, F)
    m = len(posed.working)
    return Stationarity(posed.qp, posed.unit), X[:, :m], B, posed.qp.lb[:m], posed.qp.ub[:m]


def test_the_optimum_is_at_no_distance_but_the_solver_s_own_rounding(case) -> None:
    proof, X, B, lb, ub = problem(case)
    promised = build("qp-soft/quadprog", case[0]).tolerance  # a thousandth of the least displacement below
    for x, b in zip(X, B, strict=True):
        assert proof.distance(x, b, lb, ub) < promised <= 1e-9


def test_a_displaced_point_is_as_far_as_it_was_moved(case, rng: np.random.Generator) -> None:
    proof, X, B, lb, ub = problem(case)
    for x, b in zip(X, B, strict=True):
        moved = np.clip(x + rng.uniform(-1, 1, len(x)) * rng.choice([1e-6, 1e-3, 0.1]), lb, ub)
        assert proof.distance(moved, b, lb, ub) == pytest.approx(np.abs(moved - x).max(), rel=1e-3, abs=1e-9)


def test_a_point_that_is_no_number_is_at_no_finite_distance(case) -> None:
    proof, X, B, lb, ub = problem(case)
    with np.errstate(invalid="ignore"):
        assert not proof.distance(X[0] * np.nan, B[0], lb, ub) <= 1.0


@pytest.mark.parametrize(("moved", "status"), [(0.0, None), (0.2, Status.NOT_CONVERGED)])
def test_a_solver_that_calls_a_far_answer_solved_is_not_believed(moved: float, status: Status | None) -> None:
    """The thrusts move along the null space, so the wrench is as good as before and the limits are kept."""
    vehicle = load_vehicle("bluerov2-heavy")
    allocate = build("qp-soft/daqp", vehicle)
    honest = allocate.solve  # type: ignore[attr-defined]  # Live's half, not part of the protocol
    free = np.linalg.svd(vehicle.TP)[2][-1]

    def liar(b, lb, ub):
        right = honest(b, lb, ub)
        x = right.x.copy()
        x[:8] += moved * free
        return Answer(x, Status.SOLVED)

    allocate.solve = liar  # type: ignore[attr-defined]
    answer = allocate([10.0, 0, 5, 0, 0, 1])
    assert answer.status == (status or Status.PARTIAL)
    assert np.isnan(answer.f).all() == (status is Status.NOT_CONVERGED)
