"""Look for the demand that costs a kernel most: seeded hill climbing on the exact count."""

from collections.abc import Callable

import numpy as np

from alloc import FloatArray, IndexArray

SIZE = 200
"""Demands a generation: a start of the emulator takes as long as counting a few hundred calls."""
GENERATIONS = 8
PARENTS = 20
STEPS = (1.0, 0.3, 0.1, 0.03, 0.01)
"""Spreads of a change, relative to the vehicle's wrench scale: paths change at limits, near and far."""
FRESH = 0.2
"""Share of each generation that is drawn anew, so that a hill climbed early is not the only one."""


def climb(
    cost: Callable[[FloatArray], IndexArray],
    start: FloatArray,
    scale: FloatArray,
    rng: np.random.Generator,
    generations: int = GENERATIONS,
    size: int = SIZE,
) -> tuple[FloatArray, IndexArray]:
    """Every demand that was tried (M, k) and what it cost (M,), most costly first.

    Parameters
    ----------
    cost : counts of demands (N, k)
    start : (N, k) demands to begin with
    scale : (k,) size of a wrench on each axis [N, N m]

    The first generation is random; each later one changes the most costly demands so far a little,
    mixes two of them, or is drawn anew. Ends early where all demands cost the same.
    """
    taus = np.concatenate([start, _random(rng, scale, size)])
    costs = cost(taus)
    for _ in range(generations):
        if np.ptp(costs) == 0:
            break
        # Ties in random order: a plateau is then walked along instead of sat on.
        best = np.lexsort((rng.random(len(costs)), -costs))[:PARENTS]
        children = _children(rng, taus[best], scale, size)
        taus, costs = np.concatenate([taus, children]), np.concatenate([costs, cost(children)])
    order = np.argsort(-costs, kind="stable")
    return taus[order], costs[order]


def _random(rng: np.random.Generator, scale: FloatArray, size: int) -> FloatArray:
    reach = rng.uniform(0.0, 1.5, (size, 1))  # from hardly anything to more than any thruster gives
    return reach * scale * rng.uniform(-1.0, 1.0, (size, len(scale)))


def _children(rng: np.random.Generator, parents: FloatArray, scale: FloatArray, size: int) -> FloatArray:
    one, other = parents[rng.integers(len(parents), size=(2, size))]
    share = rng.choice([0.0, 0.5], (size, 1))
    moved = rng.choice(STEPS, (size, 1)) * scale * rng.standard_normal(one.shape)
    moved *= rng.random(one.shape) < 0.5  # half of the axes, on average, stay as they are
    children = one + share * (other - one) + moved
    fresh = rng.random((size, 1)) < FRESH
    return np.where(fresh, _random(rng, scale, size), children)
