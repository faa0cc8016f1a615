"""Demands that the closed form meets inside the limits: what the paper assumes of all demands."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.rays import Rays, collect

SHARE = 0.99
"""Demands lie in this share of the part of a ray that T* tau serves, which keeps off the boundary label."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m], uniform along random rays up to where T* tau meets a limit."""
    return collect(vehicle, rng, n, _inside, "T* tau breaks a limit for every demand, even the smallest")


def _inside(rays: Rays) -> tuple[FloatArray, FloatArray]:
    low, high = rays.closed
    return np.maximum(low, 0.0), SHARE * high
