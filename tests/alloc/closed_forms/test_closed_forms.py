"""The closed forms (eq. 6-28, Appendix A), each against a second way to the same f."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from alloc import WRENCH_TOLERANCE, NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.closed_forms import svd, walsh

CLOSED = ("pinv", "svd", "walsh")
AGREE = 1e-9
"""What closed forms promise, relative to the largest |f|: rounding times cond(T), below 1e3 here."""


def vehicle_of(T: FloatArray, H: FloatArray | None = None) -> Vehicle:
    k, n = T.shape
    dof = ("surge", "sway", "heave", "roll", "pitch", "yaw")[:k]
    limit = np.full(n, 100.0)
    return Vehicle("random", dof, T, np.eye(n) if H is None else H, -limit, limit, np.ones(n), np.ones(k))


def by_lagrange(vehicle: Vehicle, tau: FloatArray) -> FloatArray:
    """f from the KKT system of eq. 6-7, solved as it stands over the thrusters that work."""
    on = vehicle.working
    T, H, m = vehicle.TP[:, on], vehicle.H[np.ix_(on, on)], len(on)
    kkt = np.block([[H, T.T], [T, np.zeros((vehicle.k, vehicle.k))]])
    f = np.zeros(vehicle.n)
    f[on] = np.linalg.solve(kkt, np.concatenate([np.zeros(m), tau]))[:m]
    return f


def answer(method: str, vehicle: Vehicle, tau: FloatArray) -> FloatArray:
    f, status, _, _ = build(method, vehicle)(tau)
    assert status is Status.SOLVED
    return f


def assert_same(f: FloatArray, expected: FloatArray) -> None:
    np.testing.assert_allclose(f, expected, rtol=0, atol=AGREE * max(1.0, np.abs(expected).max()))


@st.composite
def problems(draw: st.DrawFn) -> tuple[Vehicle, FloatArray]:
    """A vehicle with any T and any H, now and then with a thruster off or weakened, and a demand."""
    k = draw(st.integers(1, 6))
    n = draw(st.integers(k + 1, 9))
    entries = st.floats(-1, 1).map(lambda x: round(x, 3))  # as published geometry has it
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


def test_equation_9_as_printed_gives_the_same_f(vehicle: Vehicle, rng: np.random.Generator) -> None:
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
    f, status, _, _ = allocate(np.array([0, 0, 10.0, 0, 0]))
    assert status is Status.PARTIAL
    scaled = 1 / np.linalg.norm(degraded.T, axis=1)
    nearest, *_ = scipy.linalg.lstsq(scaled[:, None] * degraded.TP, scaled * [0, 0, 10.0, 0, 0])
    assert_same(f, nearest)


@pytest.mark.parametrize("method", ["pinv", "svd"])
def test_a_whole_vehicle_without_full_rank_is_served_as_far_as_it_goes(method: str) -> None:
    """Three columns of which the third is the sum of the others, so that no rounding hides the lost rank."""
    columns = np.array([[0.3, -0.7, 1.1], [0.9, 0.2, -0.4], [1.2, -0.5, 0.7]])
    vehicle = vehicle_of(columns.T)
    assert vehicle.rank == 2
    tau = vehicle.T @ [1.0, -2, 3]
    f, status, _, _ = build(method, vehicle)(tau)
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


@pytest.mark.parametrize("n", [1, 2, 4, 8, 16, 64])
def test_a_walsh_matrix_is_symmetric_orthogonal_and_in_dyadic_order(n: int) -> None:
    W = walsh.walsh_matrix(n)
    np.testing.assert_array_equal(W, W.T)
    np.testing.assert_array_equal(W @ W, n * np.eye(n))
    # Dyadic order: row i changes sign with the Rademacher functions of the bits of i, lowest bit slowest.
    bits = n.bit_length() - 1
    for i in range(n):
        for x in range(n):
            crossings = sum((i >> b & 1) * (x >> (bits - 1 - b) & 1) for b in range(bits))
            assert W[i, x] == (-1) ** crossings
    natural = scipy.linalg.hadamard(n)
    assert {tuple(row) for row in W} == {tuple(row) for row in natural}


@pytest.mark.parametrize("n", [0, -4, 3, 6, 12])
def test_no_walsh_matrix_has_such_a_size(n: int) -> None:
    with pytest.raises(NotApplicable, match="power of two"):
        walsh.walsh_matrix(n)


@given(
    alpha=st.floats(5, 85),
    arm=st.floats(0.01, 100) | st.floats(-100, -0.01),
    tau=arrays(float, 3, elements=st.floats(-1e3, 1e3)),
    order=st.permutations(range(4)),
    flipped=st.lists(st.booleans(), min_size=4, max_size=4),
    off=st.none() | st.integers(0, 3),
)
def test_walsh_is_the_pseudoinverse_for_four_thrusters_in_any_order_and_sense(
    alpha: float, arm: float, tau: FloatArray, order: list[int], flipped: list[bool], off: int | None
) -> None:
    t = np.array([np.cos(np.radians(alpha)), np.sin(np.radians(alpha)), arm])
    T = t[:, None] * np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1.0]])
    vehicle = vehicle_of(T[:, order] * np.where(flipped, -1, 1))
    if off is not None:
        vehicle = vehicle.with_fault(off)
    f = answer("walsh", vehicle, tau)
    assert_same(f, scipy.linalg.pinv(vehicle.TP) @ tau)


def test_walsh_covers_eight_thrusters_that_are_rows_of_w8(rng: np.random.Generator) -> None:
    Q = np.diag([0.9, 0.4, 0.4, 2.0, 3.0, 0.5])
    vehicle = vehicle_of(Q @ walsh.walsh_matrix(8)[2:])
    for case in (vehicle, vehicle.with_fault(5)):
        tau = case.TP @ rng.uniform(-10, 10, 8)
        assert_same(answer("walsh", case, tau), by_lagrange(case, tau))


@pytest.mark.parametrize(
    ("spoil", "premise"),
    [
        (lambda v: replace(v, H=np.diag([1, 1, 1, 2.0])), "multiple of the identity"),
        (lambda v: v.with_fault(1, 0.5), "thruster 1 is weakened"),
        (lambda v: replace(v, T=v.T * [1, 1, 1, 1.01]), "not \\+-equal"),
        (lambda v: replace(v, T=np.vstack([v.T[:2], np.zeros(4)])), "no thruster moves yaw"),
        (lambda v: replace(v, T=v.T[[0, 1, 0]]), "surge and yaw of T are not orthogonal"),
        (lambda v: vehicle_of(np.array([[1.0, 1, 1], [1, -1, 0]])), "3 thrusters move surge"),
    ],
)
def test_walsh_refuses_and_names_the_premise_that_fails(spoil, premise: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(NotApplicable, match=premise):
        build("walsh", spoil(load_vehicle("ukwial")))


def test_walsh_covers_the_vehicles_whose_fours_look_like_the_paper_s() -> None:
    covered = {"ukwial", "bluerov2-heavy", "subjugator8"}
    for path in (Path(walsh.__file__).parents[1] / "vehicles").glob("*.yaml"):
        vehicle = load_vehicle(path)
        if vehicle.name in covered:
            build("walsh", vehicle)
        elif vehicle.name in {"bluerov2", "nautilus", "supply-vessel"}:
            with pytest.raises(NotApplicable):
                build("walsh", vehicle)


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
def test_a_thruster_that_pushes_nothing_is_asked_for_nothing(method: str) -> None:
    H = np.array([[2.9155369, 0.31392192], [0.31392192, 0.62051478]])
    lost = vehicle_of(np.array([[-2.0, 0.0]]), H).with_fault(0)
    assert lost.rank == 0
    f, status, _, _ = build(method, lost)([100.0])
    assert status is Status.PARTIAL
    np.testing.assert_array_equal(f, 0.0)


SIDEWAYS = vehicle_of(np.array([[1.0, np.cos(np.pi / 2), 0.0], [0.0, 0.0, 1.0]]))
"""Thruster 1 pushes across: along surge its cos 90 deg is 6e-17."""


@pytest.mark.parametrize("method", ["pinv", "svd", "walsh", "clip", "redistribute", "nullspace", "scaled"])
def test_what_only_rounding_pushes_is_lost_and_nobody_asks_rounding_for_it(method: str) -> None:
    """After the failure 6e-17 is the largest entry of its row, and would be a direction beside itself."""
    lost = SIDEWAYS.with_fault(0).with_fault(2)
    assert lost.rank == 0
    f, status, _, _ = build(method, lost)([1.0, 0.0])
    assert status is (Status.INFEASIBLE if method == "nullspace" else Status.PARTIAL)
    assert np.isnan(f).all() or (f == 0.0).all()


@pytest.mark.parametrize("method", ["pinv", "svd", "clip", "redistribute", "nullspace", "scaled"])
@pytest.mark.parametrize("readiness", [1.0, 1e-4])
def test_solved_is_no_lie_where_h_and_t_are_far_from_one(method: str, readiness: float) -> None:
    """H weighs thruster 2 1e11 times another: singular values of T L'^-1 lie beyond a tolerance of T."""
    T = np.array([[1.0, 1.0, 1.0], [0.0, 1e-2, 1.0], [0.0, 1.0, 1.0]])
    vehicle = vehicle_of(T, np.diag([1.0, 1.0, 1e11]))
    vehicle = vehicle if readiness == 1.0 else vehicle.with_fault(2, readiness)
    expected = np.array([1.0, 2.0, 3.0])  # n = k: there is no other f
    f, status, _, _ = build(method, vehicle)(vehicle.TP @ expected)
    assert status is Status.SOLVED
    np.testing.assert_allclose(f, expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", ["pinv", "svd", "nullspace"])
def test_status_is_what_the_wrench_says_where_digits_run_out(method: str) -> None:
    """Thrusters 1e-8 to 1e-3 from parallel, weights up to 1e12 apart; demands that can be met."""
    rng = np.random.default_rng(1)
    for _ in range(400):
        k, n = 3, int(rng.integers(3, 6))
        T = rng.normal(size=(k, n))
        T[:, 1] = T[:, 0] + 10.0 ** rng.uniform(-8, -3) * rng.normal(size=k)
        vehicle = vehicle_of(T, np.diag(10.0 ** rng.uniform(-5.9, 5.9, n)))
        taus = rng.uniform(-99, 99, (4, n)) @ T.T
        F, status = build(method, vehicle).many(taus)
        assert not (status == Status.INFEASIBLE).any()
        missed = np.abs(F @ T.T - taus) / vehicle.wrench_scale
        assert (missed[status == Status.SOLVED] <= WRENCH_TOLERANCE).all()
        assert method == "svd" or (status == Status.SOLVED).all()


def in_fractions(vehicle: Vehicle, tau: FloatArray) -> FloatArray:
    """f of eq. 8-9 for a diagonal H without rounding: (T H^-1 T') y = tau by elimination, f = H^-1 T'y."""
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
