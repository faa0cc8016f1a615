"""The closed forms (eq. 6-17) against second ways to f, and what they do where rank or digits are lost."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, FloatArray
from alloc.closed_forms import svd
from alloc.discovery import find
from alloc.vehicle.condition import condition
from tests.closed_form_cases import AGREE, answer, assert_same, by_lagrange, vehicle_of

CLOSED = ("pinv", "svd", "walsh")


@st.composite
def problems(draw: st.DrawFn) -> tuple[Vehicle, FloatArray]:
    """A vehicle with any T and any H, in some cases with a thruster off or weakened, and a demand."""
    k = draw(st.integers(1, 6))
    n = draw(st.integers(k + 1, 9))
    entries = st.floats(-1, 1).map(lambda x: round(x, 3))  # published geometry has as many digits
    T = draw(arrays(float, (k, n), elements=entries))
    B = draw(arrays(float, (n, n), elements=entries))
    assume(T.any())
    vehicle = vehicle_of(T, B @ B.T + 0.1 * np.eye(n))
    if draw(st.booleans()):
        vehicle = vehicle.with_fault(draw(st.integers(0, n - 1)), draw(st.sampled_from([0.0, 0.25, 0.8])))
    assume(vehicle.rank == k and np.linalg.cond(vehicle.TP) < 100)  # the KKT system is no worse than AGREE
    return vehicle, draw(arrays(float, k, elements=st.floats(-100, 100)))


@pytest.mark.parametrize("method", ["pinv", "svd"])
@given(problem=problems())
def test_a_closed_form_solves_the_kkt_system_for_any_T_H_and_fault(
    method: str, problem: tuple[Vehicle, FloatArray]
) -> None:
    vehicle, tau = problem
    assert_same(answer(method, vehicle, tau), by_lagrange(vehicle, tau))


@pytest.mark.parametrize("method", ["pinv", "svd"])
@given(problem=problems())
def test_a_closed_form_meets_the_wrench_and_is_stationary(
    method: str, problem: tuple[Vehicle, FloatArray]
) -> None:
    vehicle, tau = problem
    f = answer(method, vehicle, tau)
    np.testing.assert_allclose(vehicle.TP @ f, tau, rtol=0, atol=AGREE * max(1.0, np.abs(tau).max()))
    # H f is a combination of the rows of T: no part of it lies in the null space.
    on = vehicle.working
    along = scipy.linalg.null_space(vehicle.TP[:, on]).T @ (vehicle.H @ f)[on]
    np.testing.assert_allclose(along, 0, atol=AGREE * max(1.0, np.abs(vehicle.H @ f).max()))


def test_pinv_is_scipy_s_pseudoinverse_where_h_is_the_identity(vehicle: Vehicle) -> None:
    expected = scipy.linalg.pinv(vehicle.T)
    for method in ("pinv", "svd"):
        columns = [answer(method, vehicle, tau) for tau in np.eye(vehicle.k)]
        assert_same(np.array(columns).T, expected)


def test_equation_9_as_printed_gives_f_of_pinv_and_svd(vehicle: Vehicle, rng: np.random.Generator) -> None:
    H = np.diag(rng.uniform(0.5, 2, vehicle.n))
    weighted = replace(vehicle, H=H)
    T, H_inv = vehicle.T, np.linalg.inv(H)
    T_star = H_inv @ T.T @ np.linalg.inv(T @ H_inv @ T.T)
    tau = vehicle.T @ rng.uniform(vehicle.f_min, vehicle.f_max)
    for method in ("pinv", "svd"):
        assert_same(answer(method, weighted, tau), T_star @ tau)


def test_all_closed_forms_agree_on_every_vehicle_and_fault(
    vehicle: Vehicle, rng: np.random.Generator
) -> None:
    for case in (vehicle, *(vehicle.with_fault(i) for i in range(vehicle.n)), vehicle.with_fault(0, 0.4)):
        thrusts = rng.uniform(case.f_min, case.f_max, (5, case.n))
        for tau in thrusts @ case.TP.T:
            expected = answer("pinv", case, tau)
            for method in CLOSED:
                try:
                    assert_same(answer(method, case, tau), expected)
                except NotApplicable:
                    assert method == "walsh"


@pytest.mark.parametrize("method", ["pinv", "svd"])
def test_a_lost_rank_gives_the_nearest_wrench_and_says_so(method: str) -> None:
    degraded = load_vehicle("bluerov2").with_fault(4)  # one vertical thruster for heave and roll
    allocate = build(method, degraded)
    reachable = degraded.TP @ np.array([1, -2, 3, 4, 0, 5.0])
    assert allocate(reachable).status is Status.SOLVED
    f, status, *_ = allocate(np.array([0, 0, 10.0, 0, 0]))
    assert status is Status.PARTIAL
    scaled = 1 / np.linalg.norm(degraded.T, axis=1)
    nearest, *_ = scipy.linalg.lstsq(scaled[:, None] * degraded.TP, scaled * [0, 0, 10.0, 0, 0])
    assert_same(f, nearest)


@pytest.mark.parametrize("method", ["pinv", "svd"])
def test_a_vehicle_of_lower_rank_without_faults_is_solved_where_it_meets_the_wrench(method: str) -> None:
    """The third of three columns is the sum of the others, so that no rounding hides the lost rank."""
    columns = np.array([[0.3, -0.7, 1.1], [0.9, 0.2, -0.4], [1.2, -0.5, 0.7]])
    vehicle = vehicle_of(columns.T)
    assert vehicle.rank == 2
    tau = vehicle.T @ [1.0, -2, 3]
    f, status, *_ = build(method, vehicle)(tau)
    assert status is Status.SOLVED
    assert_same(f, scipy.linalg.pinv(vehicle.T, rtol=1e-9) @ tau)
    assert build(method, vehicle)(np.linalg.svd(vehicle.T)[0][:, 2]).status is Status.PARTIAL


def test_svd_returns_the_factors_of_equation_11(vehicle: Vehicle, rng: np.random.Generator) -> None:
    B = rng.normal(size=(vehicle.n, vehicle.n))
    weighted = replace(vehicle, H=B @ B.T + np.eye(vehicle.n))
    U, S, V, L, rows = svd.decompose(weighted)
    np.testing.assert_allclose(U @ U.T, np.eye(vehicle.k), atol=1e-13)
    np.testing.assert_allclose(V @ V.T, np.eye(vehicle.n), atol=1e-13)
    np.testing.assert_allclose(L @ L.T, weighted.H, rtol=1e-12, atol=1e-12)
    assert (np.diff(S.diagonal()) <= 0).all()
    np.testing.assert_allclose((U @ S @ V.T @ L.T) / rows[:, None], vehicle.T, atol=1e-12 * vehicle.f_scale)


@pytest.mark.parametrize("method", ["svd", "walsh"])
def test_closed_forms_agree_on_the_nearest_wrench_where_rows_hold_different_numbers_of_thrusters(
    method: str,
) -> None:
    T = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    lost = vehicle_of(T).with_fault(0).with_fault(2)
    tau = np.array([1.0, 2.0, 3.0])
    expected = build("pinv", lost)(tau)
    assert expected.status is build(method, lost)(tau).status is Status.PARTIAL
    np.testing.assert_allclose(build(method, lost)(tau).f, expected.f, rtol=0, atol=AGREE)


@pytest.mark.parametrize("method", ["pinv", "svd"])
def test_a_thruster_that_pushes_nothing_gets_no_thrust(method: str) -> None:
    H = np.array([[2.9155369, 0.31392192], [0.31392192, 0.62051478]])
    lost = vehicle_of(np.array([[-2.0, 0.0]]), H).with_fault(0)
    assert lost.rank == 0
    f, status, *_ = build(method, lost)([100.0])
    assert status is Status.PARTIAL
    np.testing.assert_array_equal(f, 0.0)


SIDEWAYS = vehicle_of(np.array([[1.0, np.cos(np.pi / 2), 0.0], [0.0, 0.0, 1.0]]))
"""Thruster 1 pushes across, so that its entry along surge is cos 90 deg = 6e-17."""


@pytest.mark.parametrize("method", ["pinv", "svd", "walsh", "clip", "redistribute", "nullspace", "scaled"])
def test_a_direction_that_only_rounding_pushes_is_lost_and_gets_no_thrust(method: str) -> None:
    """After the failures 6e-17 is the largest entry of T P, and relative to itself would count for a rank."""
    lost = SIDEWAYS.with_fault(0).with_fault(2)
    assert lost.rank == 0
    f, status, *_ = build(method, lost)([1.0, 0.0])
    assert status is (Status.INFEASIBLE if method == "nullspace" else Status.PARTIAL)
    assert np.isnan(f).all() or (f == 0.0).all()


@pytest.mark.parametrize("method", ["pinv", "svd", "clip", "redistribute", "nullspace", "scaled"])
@pytest.mark.parametrize("readiness", [1.0, 1e-4])
def test_a_solved_answer_is_right_where_h_and_t_are_far_from_one(method: str, readiness: float) -> None:
    """H weighs thruster 2 1e11 times the others: singular values of T L'^-1 lie beyond a tolerance of T."""
    T = np.array([[1.0, 1.0, 1.0], [0.0, 1e-2, 1.0], [0.0, 1.0, 1.0]])
    vehicle = replace(vehicle_of(T, np.diag([1.0, 1.0, 1e11])), weak_limit=0.0)  # numbers, not a survey's
    vehicle = vehicle if readiness == 1.0 else vehicle.with_fault(2, readiness)
    expected = np.array([1.0, 2.0, 3.0])  # n = k: there is no other f
    f, status, *_ = build(method, vehicle)(vehicle.TP @ expected)
    assert status is Status.SOLVED
    np.testing.assert_allclose(f, expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", ["pinv", "svd", "nullspace"])
def test_a_solved_answer_meets_the_wrench_where_digits_run_out(method: str) -> None:
    """Two thrusters are 1e-8 to 1e-3 from parallel, weights up to 1e12 apart; all demands can be met.

    The exact method is refused where rounding alone would move thrusts by more than SOLVED allows.
    """
    rng = np.random.default_rng(1)
    refused = 0
    for _ in range(400):
        k, n = 3, int(rng.integers(3, 6))
        T = rng.normal(size=(k, n))
        T[:, 1] = T[:, 0] + 10.0 ** rng.uniform(-8, -3) * rng.normal(size=k)
        vehicle = vehicle_of(T, np.diag(10.0 ** rng.uniform(-5.9, 5.9, n)))
        taus = rng.uniform(-99, 99, (4, n)) @ T.T
        try:
            F, status = build(method, vehicle).many(taus)
        except NotApplicable:
            assert condition(vehicle) > 1e7
            refused += 1
            continue
        assert not (status == Status.INFEASIBLE).any()
        missed = np.abs(F @ T.T - taus) / vehicle.wrench_scale
        assert (missed[status == Status.SOLVED] <= WRENCH_TOLERANCE).all()
        assert method != "nullspace" or (status == Status.SOLVED).all()  # a closed form may say PARTIAL
    assert refused < (100 if method == "nullspace" else 1)


@pytest.mark.parametrize("method", ["pinv", "svd", "walsh", "pinv@native", "walsh@native"])
def test_a_demand_so_large_that_rounding_misses_it_is_partial(method: str) -> None:
    """Up to 1e-6 of the wrench scale SOLVED may miss; a demand of 1e12 times the scale has no such digits."""
    vehicle = load_vehicle("bluerov2-heavy")
    if missing := find(method).missing:
        pytest.skip(missing)
    allocate, rng = build(method, vehicle), np.random.default_rng(3)
    taus = 10.0 ** rng.uniform(-3, 90, (500, 1)) * rng.normal(size=(500, vehicle.k)) * vehicle.wrench_scale
    F, status = allocate.many(taus)
    missed = (np.abs(F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max(axis=1)
    assert (missed[status == Status.SOLVED] <= WRENCH_TOLERANCE).all()
    small = np.abs(taus / vehicle.wrench_scale).max(axis=1) < 1e6
    assert (status[small] == Status.SOLVED).all()
    assert 100 < np.count_nonzero(status == Status.PARTIAL) < 500
    for tau, verdict in zip(taus[:50], status[:50], strict=True):
        assert allocate(tau).status == verdict


def test_redistribute_freezes_alike_in_one_call_and_in_many(rng: np.random.Generator) -> None:
    """Demands leave a thruster at its limit exactly: rounding alone would decide whether it freezes there."""
    vehicle = vehicle_of(np.array([[-0.5, -1.5], [1.0, 2.0]]))
    vehicle = replace(vehicle, f_min=np.zeros(2), f_max=np.array([36.040586309, 98.9]))
    F = np.column_stack([rng.uniform(0.5, 1.0, 2000) * vehicle.f_max[0], np.zeros(2000)])
    F[::2, 0] = vehicle.f_max[0]
    taus = F @ vehicle.TP.T * (1 + rng.choice([0.0, 1e-6, 1e-5], (2000, 1)))
    allocate = build("redistribute", vehicle)
    together, status = allocate.many(taus)
    for tau, f, verdict in zip(taus, together, status, strict=True):
        alone = allocate(tau)
        assert alone.status == verdict
        np.testing.assert_allclose(alone.f, f, atol=1e-9 * vehicle.f_scale)


def in_fractions(vehicle: Vehicle, tau: FloatArray) -> FloatArray:
    """f of eq. 8-9 for a diagonal H, without rounding: (T H^-1 T') y = tau by elimination, f = H^-1 T'y."""
    exactly = np.vectorize(Fraction, otypes=[object])
    T, weights = exactly(vehicle.T), exactly(np.diag(vehicle.H))
    rows = np.column_stack([T / weights @ T.T, exactly(tau)])
    for i in range(vehicle.k):  # positive definite: no row is exchanged
        rows[i] /= rows[i, i]
        for other in set(range(vehicle.k)) - {i}:
            rows[other] -= rows[other, i] * rows[i]
    return (T.T @ rows[:, -1] / weights).astype(np.float64)


@pytest.mark.parametrize(("apart", "promise"), [(1e1, 1e-13), (1e4, 1e-11), (1e8, 1e-9), (9e11, 1e-6)])
def test_the_generalized_inverse_keeps_its_digits_whatever_the_weights(apart: float, promise: float) -> None:
    rng = np.random.default_rng(9)
    for _ in range(30):
        n = int(rng.integers(4, 7))
        weights = apart ** rng.permutation(np.linspace(0.0, 1.0, n))
        vehicle = vehicle_of(rng.normal(size=(3, n)), np.diag(weights))
        tau = vehicle.T @ rng.uniform(-1, 1, n)
        np.testing.assert_allclose(
            answer("pinv", vehicle, tau), in_fractions(vehicle, tau), rtol=0, atol=promise
        )
