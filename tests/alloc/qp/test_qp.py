"""The QP handed to a solver is the vehicle's allocation problem in other units."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from alloc import Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.qp import Posed, pose_hard, pose_soft
from tests.vehicles import made_up

ROUNDING = 1e-12
"""Products of matrices with condition below 1e3 on numbers scaled to 1."""


def random_vehicle(seed: int, k: int = 3, n: int = 5) -> Vehicle:
    """A vehicle with as little structure as eq. 4-5 allow: random T, full H, one-sided and uneven limits."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    f_max = rng.uniform(1, 500, n)
    f_min = -f_max * rng.choice([0.0, 0.6, 1.0], n)  # 0: thrusters that push one way only
    T = rng.normal(size=(k, n)) * rng.uniform(0.05, 2, (k, 1))
    H, weights = root @ root.T + np.eye(n), rng.uniform(100, 5000, k)
    return made_up(T, f_min, f_max, name=f"random-{seed}", H=H, slack_weights=weights)


def cases() -> list[Vehicle]:
    ukwial, six = load_vehicle("ukwial"), load_vehicle("bluerov2")
    weak = ukwial.with_fault(0, readiness=0.3)
    lost = ukwial.with_fault(0).with_fault(1)  # two thrusters left for three DOF: rank 2
    return [ukwial, weak, ukwial.with_fault(2), lost, six, six.with_fault(5), random_vehicle(1)]


@pytest.mark.parametrize("pose", [pose_hard, pose_soft])
def test_weights_stay_symmetric_to_the_last_bit(pose: Callable[..., Posed]) -> None:
    """SIP refuses others: a campaign's vehicles 1335 and 1415 among them."""
    for seed in range(20):
        H = pose(random_vehicle(seed)).qp.H
        assert np.array_equal(H, H.T)


@pytest.fixture(params=cases(), ids=lambda v: v.name)
def posed_vehicle(request: pytest.FixtureRequest) -> Vehicle:
    case: Vehicle = request.param
    return case


def thrusts(vehicle: Vehicle, n: int, rng: np.random.Generator) -> FloatArray:
    return rng.uniform(vehicle.f_min, vehicle.f_max, (n, vehicle.n))


@pytest.mark.parametrize("scaled", [True, False])
def test_a_wrench_is_met_exactly_where_the_equations_hold(
    posed_vehicle: Vehicle, scaled: bool, rng: np.random.Generator
) -> None:
    v, posed = posed_vehicle, pose_hard(posed_vehicle, scaled)
    F = thrusts(v, 50, rng)
    B, X = posed.scaled(F @ v.TP.T, F)
    np.testing.assert_allclose(X @ posed.qp.A.T, B, rtol=0, atol=ROUNDING * max(1, np.abs(B).max()))
    assert len(posed.qp.A) == np.linalg.matrix_rank(posed.qp.A) == v.rank
    # No other wrench passes: together with the unreachable directions, b determines tau.
    assert np.linalg.matrix_rank(np.vstack([posed.b_of_tau, posed.unreachable])) == v.k


def test_wrenches_that_thrusters_make_have_no_part_along_unreachable_directions(
    posed_vehicle: Vehicle, rng: np.random.Generator
) -> None:
    v, posed = posed_vehicle, pose_hard(posed_vehicle)
    assert posed.unreachable.shape == (v.k - v.rank, v.k)
    assert np.abs(thrusts(v, 50, rng) @ v.TP.T @ posed.unreachable.T).max(initial=0) < ROUNDING


def test_a_demand_along_an_unreachable_direction_reaches_no_solver(posed_vehicle: Vehicle) -> None:
    v, posed = posed_vehicle, pose_hard(posed_vehicle)
    allocate = build("qp/daqp", v)

    def forbidden(b: FloatArray) -> None:
        pytest.fail("a solver was asked")

    allocate.solve = forbidden  # type: ignore[attr-defined]  # an attribute of live methods, not of the protocol
    for direction in posed.unreachable:
        tau = 1e-6 * direction / np.linalg.norm(direction) * v.wrench_scale.max()
        f, status, *_ = allocate(tau)
        assert status == Status.INFEASIBLE
        assert np.isnan(f).all()


@pytest.mark.parametrize("scaled", [True, False])
def test_the_hard_cost_is_eq_4_up_to_a_constant(
    posed_vehicle: Vehicle, scaled: bool, rng: np.random.Generator
) -> None:
    v, posed = posed_vehicle, pose_hard(posed_vehicle, scaled)
    F = thrusts(v, 20, rng)
    _, X = posed.scaled(F @ v.TP.T, F)
    ratio = cost(posed.qp.H, X) / cost(v.H, F)
    np.testing.assert_allclose(ratio, ratio[0], rtol=ROUNDING)


@pytest.mark.parametrize("scaled", [True, False])
def test_the_soft_cost_is_fossen_s_up_to_a_constant(
    posed_vehicle: Vehicle, scaled: bool, rng: np.random.Generator
) -> None:
    v, posed = posed_vehicle, pose_soft(posed_vehicle, scaled)
    F = thrusts(v, 20, rng)
    taus = rng.normal(size=(20, v.k)) * v.wrench_scale
    B, X = posed.scaled(taus, F)
    np.testing.assert_allclose(X @ posed.qp.A.T, B, rtol=0, atol=ROUNDING * np.abs(B).max())
    slack = F @ v.TP.T - taus
    ratio = cost(posed.qp.H, X) / (cost(v.H, F) + cost(np.diag(v.slack_weights), slack))
    np.testing.assert_allclose(ratio, ratio[0], rtol=ROUNDING)


def cost(H: FloatArray, rows: FloatArray) -> FloatArray:
    value: FloatArray = np.einsum("ni,ij,nj->n", rows, H, rows) / 2
    return value


def test_limits_become_bounds_in_units_of_at_most_the_largest_limit(posed_vehicle: Vehicle) -> None:
    v, posed = posed_vehicle, pose_hard(posed_vehicle)
    np.testing.assert_allclose(posed.qp.lb * posed.unit, v.f_min[v.working], rtol=ROUNDING)
    np.testing.assert_allclose(posed.qp.ub * posed.unit, v.f_max[v.working], rtol=ROUNDING)
    assert posed.unit.max() == pytest.approx(v.f_scale)


def test_weights_far_apart_are_shared_between_the_cost_and_the_limits() -> None:
    """Weights 1e9 apart leave both 1e3 apart, and the equations keep orthonormal rows."""
    v = load_vehicle("bluerov2-heavy")
    qp = pose_hard(replace(v, H=np.diag(np.logspace(-4, 5, v.n)))).qp
    assert np.linalg.cond(qp.H) == pytest.approx(1e3)
    assert qp.ub.max() / qp.ub.min() == pytest.approx(1e3)
    np.testing.assert_allclose(qp.A @ qp.A.T, np.eye(v.rank), rtol=0, atol=ROUNDING)


def test_the_same_vehicle_in_kilonewtons_poses_the_same_problem() -> None:
    """The numbers that a solver sees do not depend on the unit, so a tolerance means the same in each."""
    v = load_vehicle("supply-vessel")
    k = replace(v, name="in kN", f_min=v.f_min / 1e3, f_max=v.f_max / 1e3)
    for pose in (pose_hard, pose_soft):
        a, b = pose(v), pose(k)
        for key in ("H", "A", "lb", "ub"):
            np.testing.assert_allclose(getattr(a.qp, key), getattr(b.qp, key), rtol=ROUNDING)
        np.testing.assert_allclose(a.b_of_tau * 1e3, b.b_of_tau, rtol=ROUNDING)


@given(seed=st.integers(0, 10_000), size=st.floats(0, 0.2))
@settings(max_examples=30, deadline=None)
def test_an_unsaturated_soft_answer_is_its_closed_form(seed: int, size: float) -> None:
    """Without active limits the gradient is 0 at f = (H + T'QT)^-1 T'Q tau."""
    v = random_vehicle(seed)
    v = replace(v, f_min=-v.f_max)
    Q = np.diag(v.slack_weights)
    tau = size * v.T @ np.random.default_rng(seed).uniform(v.f_min, v.f_max)
    closed = np.linalg.solve(v.H + v.T.T @ Q @ v.T, v.T.T @ Q @ tau)
    if (np.abs(closed) < v.f_max).all():
        f = build("qp-soft/daqp", v, level="tight")(tau).f
        np.testing.assert_allclose(f, closed, rtol=0, atol=1e-9 * v.f_scale)  # cond(H + T'QT) < 1e6


def test_the_soft_bias_fades_with_the_slack_weight() -> None:
    """The bias is of the order of H over T'QT, so ten times the weight leaves a tenth of it."""
    v = load_vehicle("ukwial")
    tau = v.T @ np.array([100.0, 50, -50, 20])
    missed = []
    for weight in (1e2, 1e3, 1e4):
        f = build("qp-soft/daqp", replace(v, slack_weights=np.full(3, weight)), level="tight")(tau).f
        missed.append(np.abs((v.T @ f - tau) / v.wrench_scale).max())
    assert missed[0] / missed[1] == pytest.approx(10, rel=0.1)
    assert missed[1] / missed[2] == pytest.approx(10, rel=0.01)


@pytest.mark.parametrize("largest", [0.5, 1.0, 2.0])
def test_the_soft_optimum_is_its_closed_form_for_limits_below_at_and_above_one_newton(largest: float) -> None:
    vehicle = replace(random_vehicle(2), f_min=-np.full(5, largest), f_max=np.full(5, largest))
    tau = 0.1 * vehicle.TP @ vehicle.f_max
    H_inverse = np.linalg.inv(vehicle.H)
    slack = np.diag(1.0 / vehicle.slack_weights)
    expected = H_inverse @ vehicle.T.T @ np.linalg.solve(vehicle.T @ H_inverse @ vehicle.T.T + slack, tau)
    assert np.abs(expected).max() < largest
    f = build("qp-soft/daqp", vehicle)(tau).f
    np.testing.assert_allclose(f, expected, rtol=0, atol=1e-9 * largest)
