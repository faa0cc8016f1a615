"""Random vehicles with all that a vehicle file may hold, for studies that look for wrong answers."""

from dataclasses import replace

import numpy as np

from alloc import DOF, FloatArray, Vehicle

MOST_DECADES = 8.0
"""Decimal powers by which the weights of H are apart, at most."""


def odd_vehicle(rng: np.random.Generator) -> Vehicle:
    """A vehicle of 1 to 6 DOF and up to four thrusters more, some alike, weakened, stuck or one-sided."""
    k = int(rng.integers(1, 7))
    n = k + int(rng.integers(0, 4 if k > 3 else 5))
    T = rng.normal(size=(k, n)) * 10.0 ** rng.uniform(-1, 1, (k, 1))
    if rng.integers(3) == 0:
        T = np.round(T * 2) / 2  # directions that repeat and cancel, as those of symmetric layouts
        T[:, :k] += np.eye(k)
    if n > k and rng.integers(4) == 0:
        T[:, -1] = T[:, 0] * rng.choice([1.0, -1.0, 0.5])  # two thrusters in one line
    if not T.any():
        T[0, 0] = 1.0
    high = 10.0 ** rng.uniform(0, 3) * rng.uniform(0.5, 2, n)
    low = -high * rng.choice([1.0, 0.6, 0.0, -0.05], n, p=[0.5, 0.2, 0.2, 0.1])
    if rng.integers(4) == 0:
        low[0] = high[0] = 0.3 * high[0]  # stuck
    readiness = np.where(rng.random(n) < 0.1, 10.0 ** rng.uniform(-3, 0, n), 1.0)
    vehicle = Vehicle(
        name="odd",
        dof=DOF[:k],
        T=T,
        H=np.eye(n),
        f_min=low,
        f_max=high,
        readiness=readiness,
        slack_weights=np.full(k, 2000.0),
    )
    kind = int(rng.integers(3))
    decades = float(rng.uniform(0, MOST_DECADES))
    return vehicle if kind == 0 else weighted(vehicle, rng, decades, full=kind == 2)


def weighted(vehicle: Vehicle, rng: np.random.Generator, decades: float, full: bool) -> Vehicle:
    """The vehicle with random weights that far apart, on the diagonal, or as eigenvalues of a full H."""
    weights = 10.0 ** rng.permutation(np.linspace(0, decades, vehicle.n))
    if not full:
        return replace(vehicle, H=np.diag(weights))
    Q = np.linalg.qr(rng.normal(size=(vehicle.n, vehicle.n)))[0]
    H = Q * weights @ Q.T
    return replace(vehicle, H=(H + H.T) / 2)


def inside(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """Demands (n, k) that random thrusts inside the limits push, some with thrusters at their limits."""
    F = rng.uniform(vehicle.f_min, vehicle.f_max, (n, vehicle.n))
    at_end = rng.random(F.shape) < rng.choice([0.0, 0.3, 0.6], (n, 1))
    F = np.where(at_end, np.where(rng.random(F.shape) < 0.5, vehicle.f_min, vehicle.f_max), F)
    taus: FloatArray = F @ vehicle.TP.T
    return taus
