"""Live solvers: what they answer, judged by equations; what they claim is not believed."""

from itertools import product

import numpy as np
import pytest

from alloc import (
    QP,
    WRENCH_TOLERANCE,
    DemandError,
    Entry,
    NotInstalled,
    SolverError,
    Status,
    Vehicle,
    alpha_max,
    build,
    catalogue,
    certify_many,
    list_vehicles,
    load_vehicle,
    pose_hard,
)
from alloc import solvers as found
from alloc.allocation import FloatArray
from alloc.solvers import Answer

VEHICLE = load_vehicle("ukwial")
CELLS = [
    pytest.param(entry.name, start, level, id=f"{entry.name}-{start}-{level}")
    for entry in catalogue()
    if entry.formulation == "hard" and entry.name.startswith("qp/") and not entry.missing
    for start, level in product(entry.starts, entry.levels)
]


def by_solver(entry: Entry) -> bool:
    return not entry.missing and entry.name.partition("/")[0] in ("qp", "qp-soft", "qpsolvers")


def demands(seed: int, n: int) -> FloatArray:
    """Wrenches of thrusts drawn inside the limits: feasible by construction, active or not."""
    rng = np.random.default_rng(seed)
    return rng.uniform(VEHICLE.f_min, VEHICLE.f_max, (n, VEHICLE.n)) @ VEHICLE.T.T


@pytest.mark.parametrize(("name", "start", "level"), CELLS)
def test_solved_means_wrench_met_inside_the_limits(name: str, start: str, level: str) -> None:
    allocate = build(name, VEHICLE, start=start, level=level)
    solved = 0
    for tau in demands(1, 100):
        f, status, _, _ = allocate(tau)
        assert np.isfinite(f).all() == (status in (Status.SOLVED, Status.PARTIAL))
        if np.isfinite(f).all():
            assert (VEHICLE.f_min <= f).all()
            assert (f <= VEHICLE.f_max).all()
        if status == Status.SOLVED:
            assert (np.abs(VEHICLE.T @ f - tau) <= WRENCH_TOLERANCE * VEHICLE.wrench_scale * 1.001).all()
            solved += 1
    if level == "tight":
        assert solved == 100


@pytest.mark.parametrize(("name", "start", "level"), CELLS)
def test_a_demand_just_outside_the_attainable_set_is_never_solved(name: str, start: str, level: str) -> None:
    """0.01 N beyond the largest surge: 4 * 250 N * cos 29 deg."""
    allocate = build(name, VEHICLE, start=start, level=level)
    most = 4 * 250 * np.cos(np.radians(29))
    for _ in range(3):
        assert allocate([most + 0.01, 0, 0]).status != Status.SOLVED
        assert allocate([5 * most, 0, 0]).status in (Status.INFEASIBLE, Status.NOT_CONVERGED)


@pytest.mark.parametrize(("name", "start", "level"), CELLS)
def test_answers_are_fresh_arrays_and_the_demand_is_left_alone(name: str, start: str, level: str) -> None:
    allocate = build(name, VEHICLE, start=start, level=level)
    tau, other = demands(2, 2)
    kept = tau.copy()
    first = allocate(tau).f
    before = first.copy()
    allocate(other)
    assert np.array_equal(first, before)
    assert np.array_equal(tau, kept)


@pytest.mark.parametrize("name", [n for n in found.names() if not found.missing(n) and n != "quadprog"])
def test_a_flag_nobody_mapped_raises_and_names_the_file(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """quadprog has no flags: it raises, and the next test is about that."""
    monkeypatch.setattr(found.load(name), "STATUS", {})
    with pytest.raises(SolverError, match=rf"alloc/solvers/{name}\.py"):
        build(f"qp/{name}", VEHICLE)([10.0, 5.0, 1.0])


def test_a_refusal_nobody_mapped_raises_too(monkeypatch: pytest.MonkeyPatch) -> None:
    module = found.load("quadprog")
    monkeypatch.setattr(module, "NO_SOLUTION", "another wording")
    with pytest.raises(SolverError, match="quadprog refused"):
        build("qp/quadprog", VEHICLE)([1e4, 0, 0])


@pytest.mark.parametrize("name", [n for n in found.names() if not found.missing(n)])
def test_any_strictly_convex_problem_is_solved_up_to_its_certificate(name: str) -> None:
    """A full H, a cost g, one-sided limits: nothing of what eq. 4-5 have by chance."""
    rng = np.random.default_rng(5)
    root = rng.normal(size=(6, 6))
    A = np.linalg.qr(rng.normal(size=(6, 3)))[0].T
    lb = np.array([-1, -0.5, 0, 0, -1, 0.2])
    ub = np.array([1, 0, 1, 0.7, 0.1, 0.3])
    qp = QP(root @ root.T / 6 + 0.1 * np.eye(6), rng.normal(size=6), A, lb, ub)
    module = found.load(name)
    X = rng.uniform(lb, ub, (20, 6))
    for start in module.STARTS:
        solve = module.prepare(qp, start, tuple(module.SETTINGS)[-1])
        answers = [solve(A @ x) for x in X]
        assert {answer.status for answer in answers} == {Status.SOLVED}
        clipped = np.clip([answer.x for answer in answers], lb, ub)
        worth = certify_many(qp, X @ A.T, clipped)
        # Tight settings stop at residuals of 1e-8 or gaps of 1e-11, whose root is a distance.
        assert worth.primal.max() < 1e-6
        assert worth.dual.max() < 1e-5
        assert worth.gap.max() < 1e-6


@pytest.mark.parametrize("vehicle_name", list_vehicles())
@pytest.mark.parametrize("entry", [e for e in catalogue() if by_solver(e)], ids=lambda e: e.name)
def test_answers_keep_the_distance_that_is_promised(entry: Entry, vehicle_name: str) -> None:
    """Against the exact method, or for the soft formulation against the tightest one."""
    vehicle = load_vehicle(vehicle_name)
    rng = np.random.default_rng(6)
    taus = 0.9 * rng.uniform(vehicle.f_min, vehicle.f_max, (20, vehicle.n)) @ vehicle.TP.T
    best = {"hard": "nullspace", "soft": "qp-soft/daqp"}[entry.formulation]
    exact, _ = build(best, vehicle, level="tight" if "/" in best else "").many(taus)
    for start, level in product(entry.starts, entry.levels):
        allocate = build(entry.name, vehicle, start=start, level=level)
        F, status = allocate.many(taus)
        answered = np.isin(status, (Status.SOLVED, Status.PARTIAL))
        assert answered.mean() >= 0.9  # HiGHS gives up on one in a few hundred
        assert np.abs(F - exact)[answered].max() <= allocate.tolerance * vehicle.f_scale


@pytest.mark.parametrize("name", [n for n in found.names() if not found.missing(n)])
def test_an_answer_does_not_change_when_the_next_is_made(name: str) -> None:
    posed = pose_hard(VEHICLE)
    one, other = (posed.b_of_tau @ tau for tau in demands(4, 2))
    for start in found.load(name).STARTS:
        solve = found.load(name).prepare(posed.qp, start, "default")
        x = solve(one).x
        kept = x.copy()
        solve(other)
        assert np.array_equal(x, kept)


def test_the_time_cap_is_one_call_s_not_all_calls_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """HiGHS's clock runs on between runs of an object."""
    pytest.importorskip("highspy")
    monkeypatch.setattr(found.load("highs"), "TIME_LIMIT_S", 0.2)
    allocate = build("qp/highs", VEHICLE)
    spent = 0.0
    while spent < 0.4:
        _, status, _, seconds = allocate([300.0, 50, -60])
        assert status == Status.SOLVED
        spent += seconds


@pytest.mark.parametrize("level", ["default", "tight"])
def test_ecos_ended_on_its_way_is_solved_only_as_near_as_promised(
    level: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it calls close to optimal is as close as its settings say; it ships with a gap of 5e-5."""
    pytest.importorskip("ecos")
    taus = demands(9, 20)
    exact, _ = build("nullspace", VEHICLE).many(taus)
    statuses = set()
    for iterations in range(3, 20):
        with monkeypatch.context() as patch:
            patch.setitem(found.load("ecos").SETTINGS[level], "max_iters", iterations)
            allocate = build("qp/ecos", VEHICLE, level=level)
            F, status = allocate.many(taus)
        solved = status == Status.SOLVED
        assert np.abs(F - exact)[solved].max(initial=0) <= allocate.tolerance * VEHICLE.f_scale
        statuses |= set(status)
    assert statuses == {Status.SOLVED, Status.NOT_CONVERGED}


def test_an_infeasible_verdict_from_a_guess_is_asked_for_again() -> None:
    """ProxQP warm calls some of these, 1 % inside the edge, infeasible at its first attempt."""
    rng = np.random.default_rng(1)
    allocate = build("qp/proxqp", VEHICLE, start="warm")
    taus = rng.uniform(-1, 1, (1000, 4)) @ VEHICLE.T.T
    _, status = allocate.many(0.99 * alpha_max(VEHICLE, taus)[:, None] * taus)
    assert not (status == Status.INFEASIBLE).any()


def test_the_one_shot_route_gives_the_live_answer() -> None:
    for tau in demands(8, 20):
        live, one_shot = (build(f"{route}/daqp", VEHICLE)(tau) for route in ("qp", "qpsolvers"))
        assert np.abs(live.f - one_shot.f).max() <= 1e-9 * VEHICLE.f_scale


def test_a_solver_that_qpsolvers_can_not_load_is_refused_not_called_a_failure(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """qpsolvers says so at each solve only, where it would pass for an answer that was not found."""
    import qpsolvers

    monkeypatch.setattr(qpsolvers, "available_solvers", ["osqp"])
    with pytest.raises(NotInstalled, match=r"qpsolvers/daqp: .*pip install -U qpsolvers\[daqp\]"):
        build("qpsolvers/daqp", VEHICLE)


def test_a_wrapper_that_does_not_fit_its_solver_is_an_error_not_a_demand_without_an_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import qpsolvers

    def outdated(*args: object) -> None:
        raise TypeError("solve() got an unexpected keyword argument")

    monkeypatch.setattr(qpsolvers, "solve_problem", outdated)
    with pytest.raises(SolverError, match=r"qpsolvers/daqp: TypeError: .*update both"):
        build("qpsolvers/daqp", VEHICLE)([10.0, 5.0, 1.0])


@pytest.mark.parametrize(("miss", "status"), [(0, 0), (1e-5, 1), (0.1, 3), (np.nan, 3)])
def test_a_solver_that_claims_too_much_is_found_out(miss: float, status: Status) -> None:
    """A liar in the solver's place: its x is the right one plus a miss, its word always SOLVED."""
    allocate = build("qp/daqp", VEHICLE, level="tight")
    honest = allocate.solve  # type: ignore[attr-defined]  # Live's half, not part of the protocol
    one = np.array([miss, 0, 0, 0])
    allocate.solve = lambda b: Answer(honest(b).x + one, Status.SOLVED)  # type: ignore[attr-defined]
    f, said, _, _ = allocate([10.0, 5.0, 1.0])
    assert said == status
    assert np.isnan(f).all() == (status == Status.NOT_CONVERGED)


def test_bad_demands_never_reach_a_solver() -> None:
    allocate = build("qp/daqp", VEHICLE)
    for tau in ([1.0, 2.0], [np.nan, 0, 0], [np.inf, 0, 0]):
        with pytest.raises(DemandError):
            allocate(tau)


@pytest.mark.parametrize("start", ["cold", "reused", "warm"])
def test_daqp_takes_thrusters_whose_limits_leave_them_one_thrust(start: str) -> None:
    eye, low, high = np.eye(2), np.array([-1.0, 1.0]), np.array([2.0, 1.0])
    vehicle = Vehicle("stuck", ("surge", "sway"), eye, eye, low, high, np.ones(2), np.ones(2))
    allocate = build("qp/daqp", vehicle, start=start)
    for _ in range(2):
        solved = allocate([0.5, 1.0])
        assert solved.status is Status.SOLVED
        np.testing.assert_allclose(solved.f, [0.5, 1.0], rtol=0, atol=1e-9)
        assert allocate([0.5, 0.5]).status is Status.INFEASIBLE
        assert allocate([3.0, 1.0]).status is Status.INFEASIBLE
