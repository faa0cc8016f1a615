"""Demands at which kernels cost most or are least exact: on the edge of what can be met, and no numbers."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray

CORNERS = 0.3
"""Share of the thrusts that make demands which stand at a limit, and of demands that are as large as a
vehicle can make them in some direction: rounding is largest there."""
SIZES = (0.3, 1.0, 1.0, 1.0 + 1e-6, 1.0 + 1e-5, 1.001, 1.1, 1.5, 10.0, 1e3)
"""Times an attainable demand, to lie inside, on the edge and beyond it."""


def attainable(vehicle: Vehicle, rng: np.random.Generator, count: int) -> FloatArray:
    """(k, count) demands that a vehicle can meet, inside and on the edge [N, N m]."""
    made: FloatArray = vehicle.TP @ thrusts(vehicle, rng, count)
    return made


def thrusts(vehicle: Vehicle, rng: np.random.Generator, count: int) -> FloatArray:
    """(n, count) thrusts within the limits, many of them at one [N]."""
    low, high = vehicle.f_min[:, None], vehicle.f_max[:, None]
    shape = (vehicle.n, count)
    ends = np.where(rng.random(shape) < 0.5, low, high)
    some = np.where(rng.random(shape) < CORNERS, ends, rng.uniform(low, high, shape))
    towards = rng.standard_normal((vehicle.k, count)) / vehicle.wrench_scale[:, None]
    largest = np.where(vehicle.TP.T @ towards > 0, high, low)
    return np.where(rng.random(count) < CORNERS, largest, some)


def extremes(vehicle: Vehicle, count: int, largest: float) -> FloatArray:
    """(N, k) demands about the edge and far outside, ``count`` of each kind, and such as overflow or are NaN.

    ``largest`` is the largest number of the precision in which they are asked. They are seeded.
    """
    rng = np.random.default_rng(2004)
    usual = (rng.choice(SIZES, count) * attainable(vehicle, rng, count)).T
    usual[rng.random(usual.shape) < 0.1] = 0.0
    odd = np.array([np.nan, np.inf, -np.inf, largest, -largest, largest / 2, -largest / 2])
    mixed = np.where(rng.random(usual.shape) < 0.5, rng.choice([0.0, *odd], usual.shape), usual)
    alone = [np.where(np.eye(vehicle.k) == 1, each, 0.0) for each in odd]
    taus = np.vstack([usual, mixed, largest * rng.uniform(-1.0, 1.0, usual.shape), *alone])
    return np.vstack([taus, np.zeros((1, vehicle.k)), np.repeat(odd[:, None], vehicle.k, axis=1)])
