"""Share of demands that each layout serves, by the closed form and exactly, and the effort."""

from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.nullspace.allocator import STEPS_LIMIT
from alloc.nullspace.region import Regions, nearest_many, steps_bound
from bench.judging.loss import FLOOR
from bench.layouts.spaces import Layouts, Spaces, subsets
from bench.record import SERVED_WITHIN

AT_ONCE = 8192
"""Layouts times demands that are worked on at once: their arrays stay in the processor's cache."""

SLACK = 1e-9
"""Excess over a limit that counts as met, relative to the largest limit, as in the exact method."""


class Shares(NamedTuple):
    """Shares of demands served (B,), and the mean effort f'Hf of the thrusts that serve them.

    Attributes
    ----------
    closed_form, exact : share of the demands [-]
    closed_form_effort, exact_effort : mean over the demands that are served, NaN without any [N^2 for H = I]
    """

    closed_form: FloatArray
    exact: FloatArray
    closed_form_effort: FloatArray
    exact_effort: FloatArray


def shares(layouts: Layouts, found: Spaces, taus: FloatArray) -> Shares:
    """Shares of the demands (N, k) that each layout serves.

    The closed form's thrusts T* tau are clipped to the limits; a demand is served where what they push errs
    by at most SERVED_WITHIN, lengths in the layout's own ``wrench_scale``. The exact method serves what is
    attainable.
    """
    step = max(AT_ONCE // max(len(taus), 1), 1)
    parts = []
    for first in range(0, len(layouts), step):
        part = slice(first, first + step)
        spaces = found.G[..., part], found.N[..., part], found.dependencies[..., part]
        parts.append(_shares(layouts.take(part), *spaces, taus))
    return Shares(*(np.concatenate(numbers) for numbers in zip(*parts, strict=True)))


def _shares(layouts: Layouts, G: FloatArray, N: FloatArray, y: FloatArray, taus: FloatArray) -> Shares:
    k, n, count = layouts.T.shape
    demands = len(taus)
    F = (G.transpose(0, 2, 1).reshape(n * count, k) @ taus.T).reshape(n, count, demands)
    lower, upper = layouts.f_min[..., None] - F, layouts.f_max[..., None] - F
    excess = np.minimum(np.maximum(lower, 0.0), upper)  # what clipping adds to each thrust
    scale = layouts.wrench_scale
    miss = np.matmul((layouts.T / scale[:, None]).transpose(2, 0, 1), excess.transpose(1, 0, 2))
    size = (1.0 / scale.T**2) @ (taus.T**2)
    by_form = (miss**2).sum(axis=1) <= SERVED_WITHIN**2 * np.maximum(size, FLOOR**2)
    weights = layouts.weights[..., None]
    effort = (F**2 * weights).sum(axis=0)
    clipped = ((F + excess) ** 2 * weights).sum(axis=0)
    inside = (excess == 0.0).all(axis=0)
    asked = np.flatnonzero(~inside)
    slack = SLACK * np.maximum(-layouts.f_min, layouts.f_max).max(axis=0)
    of = np.arange(count).repeat(demands)[asked]
    low, high = lower.reshape(n, -1).take(asked, axis=1), upper.reshape(n, -1).take(asked, axis=1)
    attainable = inside
    if steps_bound(n, n - k) <= STEPS_LIMIT:
        z, excess_left = nearest_many(Regions(N, slack), low, high, of)
        attainable.reshape(-1)[asked] = excess_left <= 1.0
        effort.reshape(-1)[asked] += (z**2).sum(axis=0)
    else:  # the exact method does not take such a layout, so it has no effort
        attainable.reshape(-1)[asked] = _inside_facets(y, low, high, slack, of)
        effort[:] = np.nan
    return Shares(
        by_form.mean(axis=1), attainable.mean(axis=1), _mean(clipped, by_form), _mean(effort, attainable)
    )


def _inside_facets(
    y: FloatArray, lower: FloatArray, upper: FloatArray, slack: FloatArray, layout: IndexArray
) -> BoolArray:
    """Mask of calls with some z, lower <= N z <= upper: for no y with y N = 0 do limits exclude y N z = 0."""
    n, size = len(lower), y.shape[1]
    met = np.ones(len(layout), dtype=bool)
    for rows, facet in zip(subsets(n, size), y, strict=True):
        least, largest, room = np.zeros(len(layout)), np.zeros(len(layout)), np.zeros(len(layout))
        for row, of_layout in zip(rows, facet, strict=True):
            weight = of_layout[layout]
            ends = weight * lower[row], weight * upper[row]
            least += np.minimum(*ends)
            largest += np.maximum(*ends)
            room += np.abs(weight) * slack[layout]
        met &= (least <= room) & (largest >= -room)
    return met


def _mean(values: FloatArray, chosen: BoolArray) -> FloatArray:
    count = chosen.sum(axis=1)
    means: FloatArray = np.where(chosen, values, 0.0).sum(axis=1) / np.where(count, count, np.nan)
    return means
