"""Allocators around a solver: what they make of its answer, prepared once or set up at each call."""

import numpy as np
import pytest
from scipy.linalg import null_space

from alloc import Status, build, load_vehicle
from alloc.errors import DemandError, NotInstalled, SolverError
from alloc.solvers import Answer

VEHICLE = load_vehicle("ukwial")


def test_the_one_shot_route_gives_the_live_answer() -> None:
    thrusts = np.random.default_rng(8).uniform(VEHICLE.f_min, VEHICLE.f_max, (20, VEHICLE.n))
    for tau in thrusts @ VEHICLE.T.T:
        live, one_shot = (build(f"{route}/daqp", VEHICLE)(tau) for route in ("qp", "qpsolvers"))
        assert np.abs(live.f - one_shot.f).max() <= 1e-9 * VEHICLE.f_scale


def test_a_solver_that_qpsolvers_can_not_load_is_refused_when_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """qpsolvers reports it only when it solves, where it would count as a demand without an answer."""
    import qpsolvers

    monkeypatch.setattr(qpsolvers, "available_solvers", ["osqp"])
    with pytest.raises(NotInstalled, match=r"qpsolvers/daqp: .*pip install -U qpsolvers\[daqp\]"):
        build("qpsolvers/daqp", VEHICLE)


def test_a_wrapper_that_does_not_fit_its_solver_is_refused_when_it_is_built(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import qpsolvers

    def outdated(*args: object) -> None:
        raise TypeError("solve() got an unexpected keyword argument")

    monkeypatch.setattr(qpsolvers, "solve_problem", outdated)
    with pytest.raises(SolverError, match=r"qpsolvers/daqp: TypeError: .*update both"):
        build("qpsolvers/daqp", VEHICLE)


@pytest.mark.parametrize(("miss", "status"), [(0, 0), (1e-5, 1), (0.1, 3), (np.nan, 3)])
def test_the_status_follows_the_miss_of_the_wrench_and_not_the_solvers_claim(
    miss: float, status: Status
) -> None:
    """A false solver stands in: its x is the right one plus a miss, and its status is always SOLVED."""
    allocate = build("qp/daqp", VEHICLE, level="tight")
    honest = allocate.solve  # type: ignore[attr-defined]  # Live's half, not part of the protocol
    error = np.array([miss, 0, 0, 0])
    allocate.solve = lambda b, lb, ub: Answer(honest(b, lb, ub).x + error, Status.SOLVED)  # type: ignore[attr-defined]
    f, judged, *_ = allocate([10.0, 5.0, 1.0])
    assert judged == status
    assert np.isnan(f).all() == (status == Status.NOT_CONVERGED)


@pytest.mark.parametrize("off", [0.0, 1e-3])
def test_a_soft_answer_is_kept_within_its_tolerance_only_though_it_makes_the_wrench(off: float) -> None:
    """A false solver stands in: it moves the right thrusts where the wrench feels nothing, and is content."""
    allocate = build("qp-soft/daqp", VEHICLE, level="tight")
    assert allocate.tolerance < 1e-3
    honest = allocate.solve  # type: ignore[attr-defined]  # Live's half, not part of the protocol
    unseen = np.zeros(VEHICLE.n + VEHICLE.k)
    unseen[: VEHICLE.n] = null_space(VEHICLE.T)[:, 0]
    assert unseen.any()
    allocate.solve = lambda b, lb, ub: Answer(honest(b, lb, ub).x + off * unseen, Status.SOLVED)  # type: ignore[attr-defined]
    f, judged, *_ = allocate([10.0, 5.0, 1.0])
    assert (judged == Status.NOT_CONVERGED) == np.isnan(f).all() == (off > allocate.tolerance)


def test_bad_demands_never_reach_a_solver() -> None:
    allocate = build("qp/daqp", VEHICLE)
    for tau in ([1.0, 2.0], [np.nan, 0, 0], [np.inf, 0, 0]):
        with pytest.raises(DemandError):
            allocate(tau)
