"""Demands uniform in the box of single-axis maxima: autopilots let these through; most are infeasible."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.strong import axis_maxima


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m], each axis uniform between its backward and forward maximum."""
    backward, forward = axis_maxima(vehicle)
    return rng.uniform(backward, forward, size=(n, vehicle.k))
