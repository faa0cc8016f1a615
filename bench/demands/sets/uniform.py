"""Demands uniform over the attainable set: a share of these demands is a share of the set."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.reach.volumes import uniform_demands
from bench.demands.strong import strong_vehicle


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n attainable demands (n, k) [N, N m], uniform in volume."""
    return uniform_demands(strong_vehicle(vehicle), rng, n)
