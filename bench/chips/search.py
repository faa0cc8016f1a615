"""Search for the call that costs a kernel most: hill climbing on the exact count, and failures."""

import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray, IndexArray
from alloc.errors import VehicleError
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.kernels import SCALARS, Kernel
from bench.chips.processors import Processor
from bench.demands.corners import extremes

SIZE = 200
"""Demands a generation: a start of the emulator takes as long as counting a few hundred calls."""
GENERATIONS = 8
PARENTS = 20
STEPS = (1.0, 0.3, 0.1, 0.03, 0.01)
"""Spreads of a change, relative to the vehicle's wrench scale: paths change at limits, near and far."""
FRESH = 0.2
"""Share of each generation that is drawn anew, so that the search leaves the hill it found first."""


def climb(
    cost: Callable[[FloatArray], IndexArray],
    start: FloatArray,
    scale: FloatArray,
    rng: np.random.Generator,
    generations: int = GENERATIONS,
    size: int = SIZE,
) -> tuple[FloatArray, IndexArray]:
    """Every demand that was tried (M, k) and its cost (M,), most costly first.

    Parameters
    ----------
    cost : counts of demands (N, k)
    start : (N, k) demands to begin with
    scale : (k,) size of a wrench on each axis [N, N m]
    rng : draws the demands
    generations : how many follow the first one
    size : demands of each generation

    The first generation is random; each later one changes the most costly demands so far a little,
    mixes two of them, or is drawn anew. Ends early where all demands cost the same.
    """
    taus = np.concatenate([start, _random(rng, scale, size)])
    costs = cost(taus)
    for _ in range(generations):
        if np.ptp(costs) == 0:
            break
        # Ties are put in random order, so that the search wanders along a plateau.
        best = np.lexsort((rng.random(len(costs)), -costs))[:PARENTS]
        children = _children(rng, taus[best], scale, size)
        taus, costs = np.concatenate([taus, children]), np.concatenate([costs, cost(children)])
    order = np.argsort(-costs, kind="stable")
    return taus[order], costs[order]


def _random(rng: np.random.Generator, scale: FloatArray, size: int) -> FloatArray:
    reach = rng.uniform(0.0, 1.5, (size, 1))  # from hardly anything to more than the thrusters give
    return reach * scale * rng.uniform(-1.0, 1.0, (size, len(scale)))


def _children(rng: np.random.Generator, parents: FloatArray, scale: FloatArray, size: int) -> FloatArray:
    first, second = parents[rng.integers(len(parents), size=(2, size))]
    share = rng.choice([0.0, 0.5], (size, 1))
    moved = rng.choice(STEPS, (size, 1)) * scale * rng.standard_normal(first.shape)
    moved *= rng.random(first.shape) < 0.5  # half of the axes, on average, stay as they are
    children = first + share * (second - first) + moved
    fresh = rng.random((size, 1)) < FRESH
    return np.where(fresh, _random(rng, scale, size), children)


CALLS = 50
"""Demands of each kind for each fault: about the edge of what is left, far outside, and such as overflow."""


def with_fault_argument(kernel: Kernel) -> Kernel:
    """The same kernel, called with the fault as one number more behind tau."""
    return replace(kernel, k=kernel.k + 1, arguments=kernel.arguments.replace("-1", f"(int)tau[{kernel.k}]"))


def worst_with_fault(kernel: Kernel, processor: Processor, vehicle: Vehicle, taus: FloatArray) -> int | None:
    """Most instructions of a call with any one thruster off; None where none can be.

    Asked are demands at the limits of what is left, and those (N, k) that cost the whole vehicle most.
    """
    asked = []
    largest = float(np.finfo(SCALARS[kernel.scalar]).max)
    for fault in range(vehicle.n):
        with suppress(VehicleError):  # the last thruster that pushes can't be taken off
            some = np.vstack([extremes(vehicle.with_fault(fault), CALLS, largest), taus])
            asked.append(np.column_stack([some, np.full(len(some), float(fault))]))
    if not asked:
        return None
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        other = with_fault_argument(kernel)
        calls = other.calls(np.vstack(asked), vehicle.f_min, vehicle.f_max)
        return int(count(link(other, processor, Path(folder)), calls).instructions.max())
