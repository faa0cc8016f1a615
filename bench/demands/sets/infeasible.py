"""Demands that exceed what the thrusters can do by 2 % to 100 %."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.rays import Rays, collect

BEYOND = (1.02, 2.0)
"""Multiples of alpha*: smaller ones belong to ``boundary``; a saturated controller asks for twice alpha*."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m], each alpha* tau of a random ray times 1.02 to 2."""
    return collect(vehicle, rng, n, _beyond, "no ray of demands leaves the attainable set")


def _beyond(rays: Rays) -> tuple[FloatArray, FloatArray]:
    high = rays.attainable[1]
    return BEYOND[0] * high, BEYOND[1] * high
