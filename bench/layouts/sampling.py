"""Which layouts a round has: points of a Sobol' sequence, all of a grid, or points around the best so far."""

import msgspec
import numpy as np

from alloc.allocation import FloatArray
from bench.layouts.space import LayoutSpace

SHARD = 4096
"""Layouts of a shard: about a second's work, which is what a killed worker costs. A power of 2, as a Sobol'
sequence is even over such pieces."""


class ShardTask(msgspec.Struct, frozen=True, kw_only=True):
    """A piece of a round.

    Attributes
    ----------
    round : 0 for the study's own layouts, 1, 2, … for those around the best
    index : which piece of the round
    first, count : its layouts, counted within the round
    sampling : sobol or grid
    seed : of the round's sequence
    around : shares of the way of each parameter, for each of the best layouts
    width : of the piece of each span that is drawn from around those
    """

    round: int
    index: int
    first: int
    count: int
    sampling: str
    seed: int
    around: tuple[tuple[float, ...], ...] = ()
    width: float = 1.0


def tasks(
    round_: int,
    n: int,
    sampling: str,
    seed: int,
    around: tuple[tuple[float, ...], ...] = (),
    width: float = 1.0,
) -> list[ShardTask]:
    """The pieces of a round of n layouts."""
    return [
        ShardTask(
            round=round_,
            index=index,
            first=first,
            count=min(SHARD, n - first),
            sampling=sampling,
            seed=seed + round_,
            around=around,
            width=width,
        )
        for index, first in enumerate(range(0, n, SHARD))
    ]


def values(space: LayoutSpace, task: ShardTask) -> FloatArray:
    """(P, count) the parameters of a task's layouts; the same whoever asks."""
    if task.sampling == "grid" and not task.around:
        sides = [parameter.grid for parameter in space.parameters]
        number = np.arange(task.first, task.first + task.count)
        places = np.unravel_index(number, [len(side) for side in sides])
        return np.array([side[place] for side, place in zip(sides, places, strict=True)])
    share = _sobol(len(space.parameters), task).T
    if task.around:
        centre = np.array(task.around)[(task.first + np.arange(task.count)) % len(task.around)].T
        moved = np.clip(centre + (share - 0.5) * task.width, 0.0, 1.0)
        listed = np.array([bool(parameter.choices) for parameter in space.parameters])
        share = np.where(listed[:, None], centre, moved)  # choices from a list stay as they are
    return np.array([parameter.at(column) for parameter, column in zip(space.parameters, share, strict=True)])


def _sobol(parameters: int, task: ShardTask) -> FloatArray:
    from scipy.stats import qmc

    sequence = qmc.Sobol(parameters, scramble=True, rng=np.random.default_rng(task.seed))
    if task.first:  # SciPy refuses to go forward by nothing
        sequence.fast_forward(task.first)
    drawn: FloatArray = sequence.random(SHARD)[: task.count]  # a whole power of 2, as the sequence wants
    return drawn
