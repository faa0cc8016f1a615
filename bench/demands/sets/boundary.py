"""Demands 1e-5 to 1e-3 inside or outside the edge of the attainable set: where solvers disagree."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.rays import draw

BANDS = (1e-5, 1e-3)
"""Nearest and farthest |alpha* - 1|."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m], by turns inside and outside; the logarithm of the distance is uniform."""
    rays = draw(vehicle, rng, n)
    nearest, farthest = BANDS
    distance = nearest * (farthest / nearest) ** rng.random(n)
    side = np.where(np.arange(n) % 2 == 0, -1.0, 1.0)
    edge: FloatArray = rays.attainable[1] / (1 - side * distance)
    return rays.taus * edge[:, None]
