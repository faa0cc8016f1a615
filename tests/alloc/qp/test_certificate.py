"""Certificates: valid for any x, zero at the optimum, and as tight as the multipliers allow."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from alloc import Status, Vehicle, build, list_vehicles, load_vehicle, solvers
from alloc.allocation import FloatArray
from alloc.qp import QP, certificate, pose_hard, pose_soft
from alloc.qp.certificate import certify, certify_many

FLOOR = 1e-7
"""Rounding leaves 1e-15 in a gap of order 1, so its root can't show a distance below some 1e-8."""


def random_problem(seed: int, m: int = 6, p: int = 3) -> tuple[QP, np.random.Generator]:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(m, m))
    A = np.linalg.qr(rng.normal(size=(m, p)))[0].T
    ub = rng.uniform(0.3, 1, m)
    lb = -ub * rng.choice([0.0, 1.0], m)
    return QP(H=root @ root.T / m + 0.1 * np.eye(m), g=rng.normal(size=m), A=A, lb=lb, ub=ub), rng


def optimum(qp: QP, b: FloatArray) -> FloatArray:
    """The optimum by a dual active set method, which uses no certificate."""
    answer = solvers.load("daqp").prepare(qp, "cold", "tight")(b, qp.lb, qp.ub)
    assert answer.status == Status.SOLVED
    return answer.x


def points(qp: QP, rng: np.random.Generator, n: int = 20) -> FloatArray:
    """Points inside the bounds with some coordinates on them, optimal for no problem in particular."""
    x = rng.uniform(qp.lb, qp.ub, (n, len(qp.lb)))
    on = rng.random(x.shape) < 0.3
    return np.where(on, np.where(rng.random(x.shape) < 0.5, qp.lb, qp.ub), x)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_the_distance_to_the_optimum_is_never_above_its_bound(seed: int) -> None:
    qp, rng = random_problem(seed)
    X = points(qp, rng)
    bounds = certify_many(qp, X @ qp.A.T, X)
    for x, gap, distance in zip(X, bounds.gap, bounds.distance, strict=True):
        away = x - optimum(qp, qp.A @ x)
        assert away @ qp.H @ away / 2 <= gap + FLOOR
        assert np.abs(away).max() <= distance + FLOOR


@given(seed=st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_the_gap_is_the_least_that_any_multiplier_gives(seed: int) -> None:
    """Another way to that minimum is a linear program in (y, z_upper, z_lower)."""
    qp, rng = random_problem(seed)
    p, m = qp.A.shape
    for x in points(qp, rng, 3):
        cost = np.concatenate([np.zeros(p), qp.ub - x, x - qp.lb])
        stationary = np.hstack([qp.A.T, np.eye(m), -np.eye(m)])
        bounds = [(None, None)] * p + [(0, None)] * (2 * m)
        least = linprog(cost, A_eq=stationary, b_eq=-(qp.H @ x + qp.g), bounds=bounds)
        assert certify(qp, qp.A @ x, x).gap == pytest.approx(least.fun, rel=1e-7, abs=1e-9)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_each_number_of_a_certificate_is_zero_at_the_optimum(seed: int) -> None:
    qp, rng = random_problem(seed)
    b = qp.A @ points(qp, rng, 1)[0]
    x = np.clip(optimum(qp, b), qp.lb, qp.ub)
    primal, dual, complementarity, gap, _ = certify(qp, b, x)
    assert max(primal, dual, complementarity, gap) < 1e-9


def test_each_number_of_a_certificate_grows_with_the_step_away_from_the_optimum() -> None:
    qp, rng = random_problem(7)
    b = qp.A @ points(qp, rng, 1)[0]
    x = optimum(qp, b)
    inward = (qp.lb + qp.ub) / 2 - x
    for values in certify_many(qp, b, x + np.array([[0.0], [0.01], [0.1]]) * inward):
        assert values[0] < values[1] < values[2]


@pytest.mark.parametrize("name", list_vehicles())
def test_the_exact_method_is_certified_on_every_vehicle(name: str, rng: np.random.Generator) -> None:
    v = load_vehicle(name)
    taus = rng.uniform(v.f_min, v.f_max, (100, v.n)) @ v.TP.T
    F, status = build("nullspace", v).many(taus)
    assert (status == Status.SOLVED).all()
    posed = pose_hard(v)
    certified = certify_many(posed.qp, *posed.scaled(taus, F))
    assert certified.gap.max() < 1e-12
    assert certified.primal.max() < 1e-12


@pytest.mark.parametrize("size", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("name", ["ukwial", "bluerov2", "supply-vessel"])
def test_soft_answers_are_certified_from_the_thrusts_alone(
    name: str, size: float, rng: np.random.Generator
) -> None:
    v = load_vehicle(name)
    taus = size * rng.uniform(v.f_min, v.f_max, (50, v.n)) @ v.TP.T
    best, _ = build("qp-soft/daqp", v, level="tight").many(taus)
    worse = soft_steps(v, best, rng)
    posed = pose_soft(v)
    assert certify_many(posed.qp, *posed.scaled(taus, best)).gap.max() < 1e-12
    bound = certify_many(posed.qp, *posed.scaled(taus, worse)).distance
    assert (np.abs(worse - best).max(axis=1) / v.f_scale <= bound + FLOOR).all()


def soft_steps(vehicle: Vehicle, F: FloatArray, rng: np.random.Generator) -> FloatArray:
    inside = rng.uniform(vehicle.f_min, vehicle.f_max, F.shape)
    return F + rng.choice([1e-4, 1e-2, 1.0], (len(F), 1)) * (inside - F)


def test_certify_many_agrees_with_certify_on_each_row_also_in_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    qp, rng = random_problem(3)
    X = points(qp, rng)
    whole = certify_many(qp, X @ qp.A.T, X)
    monkeypatch.setattr(certificate, "CHUNK", 1000)
    chunked = certify_many(qp, X @ qp.A.T, X)
    for i, x in enumerate(X):
        np.testing.assert_allclose([v[i] for v in whole], certify(qp, qp.A @ x, x), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(chunked, whole, rtol=1e-9, atol=1e-12)


def test_a_missed_equation_and_a_broken_bound_count_as_primal_violation() -> None:
    qp, rng = random_problem(4)
    x = points(qp, rng, 1)[0]
    b = qp.A @ x
    assert certify(qp, b + np.array([0, 0.25, 0]), x).primal == pytest.approx(0.25)
    outside = x.copy()
    outside[2] = qp.ub[2] + 0.5
    assert certify(qp, qp.A @ outside, outside).primal == pytest.approx(0.5)


def test_a_nan_answer_has_a_nan_certificate_and_no_answers_an_empty_one() -> None:
    qp, rng = random_problem(5)
    X = points(qp, rng, 2)
    B = X @ qp.A.T
    X[1] = np.nan
    assert all(np.isfinite(values[0]) and np.isnan(values[1]) for values in certify_many(qp, B, X))
    assert all(len(values) == 0 for values in certify_many(qp, B[:0], X[:0]))
