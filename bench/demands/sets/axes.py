"""Sweeps through each single axis, from a little beyond one end to a little beyond the other."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.strong import axis_maxima

OVERSHOOT = 1.1
"""Reach of a sweep, relative to the axis's maximum: a tenth beyond, so that it crosses both edges."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m], axis after axis, each in even steps; ``rng`` is not used."""
    backward, forward = axis_maxima(vehicle)
    taus = np.zeros((n, vehicle.k))
    for axis, rows in enumerate(np.array_split(np.arange(n), vehicle.k)):
        taus[rows, axis] = OVERSHOOT * np.linspace(backward[axis], forward[axis], len(rows))
    return taus
