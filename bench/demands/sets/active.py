"""Attainable demands for which the closed form breaks a limit: here a constrained method earns its cost."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.rays import Rays, collect

CLEAR = 0.002
"""Share of alpha left free at either end, so that no demand touches the boundary label (1e-3)."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m], uniform along random rays between the closed form's limit and alpha*."""
    absent = (
        "no demand is attainable only by a constrained method: with d = n - rank T = "
        f"{vehicle.nullity} the closed form meets all that the thrusters can do"
    )
    return collect(vehicle, rng, n, _between, absent)


def _between(rays: Rays) -> tuple[FloatArray, FloatArray]:
    closed = np.maximum(rays.closed[1], 0.0)
    return np.maximum(closed, rays.attainable[0]) * (1 + CLEAR), rays.attainable[1] * (1 - CLEAR)
