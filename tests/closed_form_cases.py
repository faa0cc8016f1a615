"""Vehicles for the tests of closed forms, and a second way to f."""

import numpy as np

from alloc import Status, Vehicle, build
from alloc.allocation import FloatArray
from tests.vehicles import made_up

AGREE = 1e-9
"""The promise of closed forms, relative to the largest |f|: rounding times cond(T), below 1e3 here."""


def vehicle_of(T: FloatArray, H: FloatArray | None = None) -> Vehicle:
    """A vehicle with that T (k, n) and H (n, n), the identity if None, and limits of 100 N."""
    return made_up(T, H=np.eye(T.shape[1]) if H is None else H)


def by_lagrange(vehicle: Vehicle, tau: FloatArray) -> FloatArray:
    """f from the KKT system of eq. 6-7, solved as it stands over the thrusters that work."""
    on = vehicle.working
    T, H, m = vehicle.TP[:, on], vehicle.H[np.ix_(on, on)], len(on)
    kkt = np.block([[H, T.T], [T, np.zeros((vehicle.k, vehicle.k))]])
    f = np.zeros(vehicle.n)
    f[on] = np.linalg.solve(kkt, np.concatenate([np.zeros(m), tau]))[:m]
    return f


def answer(method: str, vehicle: Vehicle, tau: FloatArray) -> FloatArray:
    """The method's thrusts (n,) for a wrench (k,) that it must solve."""
    f, status, *_ = build(method, vehicle)(tau)
    assert status is Status.SOLVED
    return f


def assert_same(f: FloatArray, expected: FloatArray) -> None:
    """Assert that thrusts agree within the promise of closed forms."""
    np.testing.assert_allclose(f, expected, rtol=0, atol=AGREE * max(1.0, np.abs(expected).max()))
