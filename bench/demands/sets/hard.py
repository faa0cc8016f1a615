"""Sequences that hurt: recovery from failure, a saturated stretch, jumps, corners, nothing at all.

They matter to whatever is carried over from call to call: a warm start, a reused object's step sizes.
"""

import numpy as np

from alloc import WRENCH_TOLERANCE, FloatArray, Vehicle
from bench.demands.rays import draw

RUN = 5
"""Infeasible demands in a row, and attainable ones after them: enough for a solver to adapt to either."""
DWELL = 100
"""Steps in one place on the edge: ten seconds of full power at 10 Hz."""
JITTER = WRENCH_TOLERANCE
"""How far those steps lie inside or outside by turns: at what counts as met."""


def demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """n demands (n, k) [N, N m]: equal parts of ``recovery``, ``dwell``, ``jumps``, ``corners``, zero."""
    counts = [len(part) for part in np.array_split(np.arange(n), 5)]
    parts = [make(vehicle, rng, count) for make, count in zip(SEQUENCES, counts, strict=False)]
    return np.concatenate([*parts, np.zeros((counts[-1], vehicle.k))])


def recovery(vehicle: Vehicle, rng: np.random.Generator, n: int) -> FloatArray:
    """Runs of demands 1e-5 to 0.5 beyond the edge, each followed by as many that far inside it.

    A demand just beyond is where an iterative solver works longest to no end, and adapts to it; one
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
    """The farthest wrench in random directions: every thruster that pushes that way is at a limit."""
    directions = rng.normal(size=(n, vehicle.k)) / vehicle.wrench_scale
    f = np.where(directions @ vehicle.TP > 0, vehicle.f_max, vehicle.f_min)
    farthest: FloatArray = f @ vehicle.TP.T
    return farthest


SEQUENCES = (recovery, dwell, jumps, corners)
