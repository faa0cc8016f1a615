"""A full H made the identity: the same problem in other variables, by its equations."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import Status, Vehicle, build, load_vehicle
from alloc.qp import pose_hard
from alloc.qp.problem import whitened


def full(vehicle: Vehicle, decades: float, rng: np.random.Generator) -> Vehicle:
    """The vehicle with a full H whose eigenvalues are so many decimal powers apart."""
    Q = np.linalg.qr(rng.normal(size=(vehicle.n, vehicle.n)))[0]
    H = Q * np.logspace(0, decades, vehicle.n) @ Q.T
    return replace(vehicle, H=(H + H.T) / 2)


def test_cost_and_equations_are_the_same_in_the_new_variables(rng: np.random.Generator) -> None:
    qp = pose_hard(full(load_vehicle("bluerov2-heavy"), 3, rng)).qp
    white = whitened(qp)
    assert white is not None
    x = rng.normal(size=len(qp.g))
    y = np.linalg.solve(white.back, x)
    np.testing.assert_allclose(y @ y + white.g @ y, x @ qp.H @ x + qp.g @ x, rtol=1e-9)
    np.testing.assert_allclose(white.A @ y, white.turn @ (qp.A @ x), atol=1e-9)
    np.testing.assert_allclose(white.A @ white.A.T, np.eye(len(qp.A)), atol=1e-12)
    assert whitened(pose_hard(load_vehicle("bluerov2-heavy")).qp) is None  # a diagonal H needs none of it


def test_quadprog_finds_the_exact_answers_of_a_full_h(rng: np.random.Generator) -> None:
    """Weights 1e6 apart; demands a hundredth inside the edge, or farther."""
    pytest.importorskip("quadprog")
    vehicle = full(load_vehicle("bluerov2-heavy"), 6, rng)
    taus = 0.99 * rng.uniform(vehicle.f_min, vehicle.f_max, (100, vehicle.n)) @ vehicle.TP.T
    exact, _ = build("nullspace", vehicle).many(taus)
    allocate = build("qp/quadprog", vehicle)
    F, status = allocate.many(taus)
    assert (status == Status.SOLVED).all()
    assert np.abs(F - exact).max() <= allocate.tolerance * vehicle.f_scale
