"""Sequences that are hard for solvers: recovery from failure, saturation, jumps, corners, zero demands.

They test what a method carries over from call to call, such as a warm start or a reused object's step sizes.
"""

import numpy as np

from alloc import Vehicle
from alloc.allocation import WRENCH_TOLERANCE, FloatArray
from alloc.reach.zonotope import farthest_thrusts
from bench.demands.rays import draw
from bench.demands.strong import strong_vehicle

RUN = 5
"""Infeasible demands in a row, and then attainable ones: enough for a solver to adapt to either."""
DWELL = 100
"""Demands at one place on the edge: ten seconds of full power at 10 Hz."""
JITTER = WRENCH_TOLERANCE
"""Largest distance of a dwelling demand from the edge: by what still counts as met."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m]: equal parts of ``recovery``, ``dwell``, ``jumps``, ``corners``, zero."""
    counts = [len(part) for part in np.array_split(np.arange(n), 5)]
    parts = [make(vehicle, rng, count) for make, count in zip(SEQUENCES, counts, strict=False)]
    return np.concatenate([*parts, np.zeros((counts[-1], vehicle.k))])


def recovery(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """Runs of demands 1e-5 to 0.5 beyond the edge, each followed by as many that far inside it.

    At a demand just beyond the edge an iterative solver works longest, in vain, and adapts to it; a demand
    just inside then shows what that adaptation costs.
    """
    rays = draw(vehicle, rng, n)
    distance = 10.0 ** rng.uniform(-5, np.log10(0.5), n)
    side = np.where(np.arange(n) // RUN % 2 == 0, 1, -1)
    return rays.taus * ((1 + side * distance) * rays.attainable[1])[:, None]


def dwell(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """One demand on the edge for ``DWELL`` steps, then another, with a jitter across the edge."""
    place = np.arange(n) // DWELL
    rays = draw(vehicle, rng, len(np.unique(place)))
    edge = rays.taus * rays.attainable[1][:, None]
    moved: FloatArray = edge[place] * (1 + rng.uniform(-JITTER, JITTER, n))[:, None]
    return moved


def jumps(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """From just inside one end of a ray to just inside the other, and on to the next ray."""
    rays = draw(vehicle, rng, (n + 1) // 2)
    backward, forward = (0.95 * rays.taus * end[:, None] for end in rays.attainable)
    return np.stack([backward, forward], axis=1).reshape(-1, vehicle.k)[:n]


def corners(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """The farthest wrenches in random directions, with every thruster at a limit."""
    vehicle = strong_vehicle(vehicle)
    directions = rng.normal(size=(n, vehicle.k)) / vehicle.wrench_scale
    farthest: FloatArray = farthest_thrusts(vehicle, directions @ vehicle.TP) @ vehicle.TP.T
    return farthest


SEQUENCES = (recovery, dwell, jumps, corners)
