"""Random vehicles with all that a vehicle file may hold, and demands that look for wrong answers."""

from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from alloc import NotApplicable, Status, Vehicle, build
from alloc.allocation import BoolArray, FloatArray
from alloc.errors import VehicleError
from alloc.reach.attainable import alpha_range
from alloc.vehicle.geometry import DOF
from bench.demands.sets.jolts import within

MOST_DECADES = 8.0
"""Decimal powers by which the weights of H are apart, at most."""

DEMANDS = 50
"""Demands of a vehicle within its own limits, and as many within others."""
EDGE = 1e-6
"""Share by which a demand must lie inside the edge to count as attainable, by the facets alone."""
FACTORS = (1.0, 1.0, 1 - 1e-5, 0.5, 1 + 1e-5, 2.0)
"""What demands that thrusts inside the limits push are multiplied by."""


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


def vehicle_of(number: int) -> tuple[Vehicle, np.random.Generator]:
    """A numbered odd vehicle, some with a thruster off, and what its demands are drawn from."""
    rng = np.random.default_rng([2004, number])
    vehicle = odd_vehicle(rng)
    if number % 4 == 0:
        with suppress(VehicleError):  # the last thruster that pushes can't be taken off
            return vehicle.with_fault(number % vehicle.n), rng
    return vehicle, rng


class DemandsAsked(NamedTuple):
    """Demands of one vehicle within limits of one kind, and what is known of them.

    Attributes
    ----------
    taus : (N, k) [N, N m]
    low, high : (N, n) limits of each [N]
    own : whether these are the vehicle's
    attainable : (N,) whether some thrusts inside the limits push the demand, beyond doubt
    optimum : (N, n) the exact method's answer [N], NaN where there is none
    doubt : what that method promises, relative to the largest limit [-]
    """

    taus: FloatArray
    low: FloatArray
    high: FloatArray
    own: bool
    attainable: BoolArray
    optimum: FloatArray
    doubt: float

    def limits(self, count: int) -> tuple[FloatArray, ...]:
        """f_min and f_max of the first demands, nothing where they are the vehicle's."""
        return () if self.own else (self.low[:count], self.high[:count])


def asked(vehicle: Vehicle, rng: np.random.Generator) -> list[DemandsAsked]:
    """Demands within the vehicle's own limits, and within limits that jump."""
    factors = rng.choice(FACTORS, DEMANDS)
    taus = inside(vehicle, rng, DEMANDS) * factors[:, None]
    shape = (DEMANDS, vehicle.n)
    own = (taus, np.broadcast_to(vehicle.f_min, shape), np.broadcast_to(vehicle.f_max, shape))
    moved, low, high = within(vehicle, rng, DEMANDS)
    pushed = (low <= high).all(axis=1) & (rng.random(DEMANDS) < 0.5)
    moved[pushed] = rng.uniform(low[pushed], high[pushed]) @ vehicle.TP.T
    sets = []
    for (demands, lows, highs), made in ((own, factors == 1.0), ((moved, low, high), pushed)):
        is_own = made is not pushed
        limits = () if is_own else (lows, highs)
        least, most = alpha_range(vehicle, demands, *limits)
        attainable = made | ((least <= 1 - EDGE) & (most >= 1 + EDGE))
        optimum, doubt = np.full(shape, np.nan), np.inf
        try:
            exact = build("nullspace", vehicle)
        except NotApplicable:
            pass
        else:
            F, status = exact.many(demands, *limits)
            optimum, doubt = np.where((status == Status.SOLVED)[:, None], F, np.nan), exact.tolerance
        sets.append(DemandsAsked(demands, lows, highs, is_own, attainable, optimum, doubt))
    return sets
