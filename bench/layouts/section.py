"""Volume of what a closed form makes within the limits: the part of their box that lies in the range of T*.

T* gives the f with N'H f = 0, so what it makes within the limits is a section of a box. Its volume is the
density at 0 of sum_i m_i f_i, f_i even between its limits, m_i the rows of H N: a box spline. A section is
the sum of pyramids over its faces, and a face fixes one thruster at a limit and is again a section (de Boor,
"The evaluation of box splines", 1993); faces of one dimension are segments, whose length is a clamp.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from bench.layouts.minors import dependencies, inverse, minors, subsets
from bench.layouts.spaces import Layouts, Spaces

MOST_THRUSTERS = 8
"""Most thrusters whose faces are added up: each at a limit or free, n have 3^n."""

NUDGE = 1e-11
"""Share by which limits are moved apart, each differently. Symmetric layouts have faces that only touch the
section; a section is continuous in its limits, so nudged it has the same volume and no such faces. The error
by rounding is a hundredth of this."""

APART = np.modf(np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0]))[0]
"""Share of NUDGE by which each thruster's limits are moved. A face touches the section where sums of limits
are equal, so no two sums of these shares, with any signs, may be equal."""


class _Level(NamedTuple):
    """Faces with ``fixed`` thrusters at a limit: which, and where the faces lie that fix one more.

    Attributes
    ----------
    fixed : (C, j) thrusters at a limit
    free : (C, n - j) the others
    signs : (2^j, j) at the upper limit (1) or the lower one (-1)
    child : (C, n - j) place of fixed + one free among the larger sets
    below, above : (C, n - j, 2^j) place of the signs with the lower, the upper limit for that one
    """

    fixed: IndexArray
    free: IndexArray
    signs: FloatArray
    child: IndexArray
    below: IndexArray
    above: IndexArray


AT_ONCE = 64
"""Layouts that are worked on at once: their faces stay in the processor's cache."""


@lru_cache(maxsize=16)
def _levels(n: int, k: int) -> tuple[_Level, ...]:
    levels = []
    for j in range(k):
        place = {tuple(s): i for i, s in enumerate(subsets(n, j + 1).tolist())}
        fixed = subsets(n, j)
        free = np.array([[i for i in range(n) if i not in s] for s in fixed.tolist()], dtype=np.intp)
        bits = np.arange(2**j)
        child, below = np.empty_like(free), np.empty((*free.shape, 2**j), dtype=np.intp)
        position = np.empty_like(free)
        for row, members in enumerate(fixed.tolist()):
            for slot, i in enumerate(free[row].tolist()):
                child[row, slot] = place[tuple(sorted([*members, i]))]
                at = position[row, slot] = sum(m < i for m in members)
                below[row, slot] = (bits >> at << (at + 1)) | (bits & ((1 << at) - 1))
        signs = np.where(bits[:, None] >> np.arange(j) & 1, 1.0, -1.0)
        above = below | (1 << position)[..., None]
        levels.append(_Level(fixed, free, signs, child, below, above))
    return tuple(levels)


def closed_form_volumes(layouts: Layouts, found: Spaces) -> FloatArray:
    """(B,) volume of {tau : f_min <= T* tau <= f_max}, unit of ``volumes``; NaN above MOST_THRUSTERS."""
    n, d, count = found.N.shape
    if n > MOST_THRUSTERS:
        return np.full(count, np.nan)
    width = layouts.f_max - layouts.f_min
    if d == 0:
        everything: FloatArray = found.content * np.abs(found.minors[0]) * width.prod(axis=0)
        return everything
    gram = np.einsum("idb,ieb->deb", found.N, found.N)
    # |det [T; N'H]| turns the density of N'H f into a volume of T f; det N'N makes up for N'HN = I.
    determinant = found.content / np.sqrt(minors(gram)[0])
    parts = (slice(first, first + AT_ONCE) for first in range(0, count, AT_ONCE))
    volume: FloatArray = determinant * np.concatenate(
        [_densities(layouts.take(p), found.N[..., p]) for p in parts]
    )
    return volume


def _densities(layouts: Layouts, N: FloatArray) -> FloatArray:
    """(B,) density of N'H f at 0, f even between the limits."""
    n, d, _ = N.shape
    width = layouts.f_max - layouts.f_min
    m = N * layouts.weights[:, None]
    half = 0.5 * width * (1.0 + NUDGE * APART[:n])[:, None]
    start = np.einsum("idb,ib->db", m, (layouts.f_max + layouts.f_min) / 2)
    levels = _levels(n, n - d)
    volume = _segments(levels[-1], m, half, start)
    for dimension, level in enumerate(reversed(levels[:-1]), start=2):
        P = _pseudoinverses(level, m)
        weights = np.einsum("csdb,cpdb->cpsb", _sums(level, m, half, start), P)
        wide = half[level.free][:, :, None]
        above = volume[level.child[..., None], level.above]
        below = volume[level.child[..., None], level.below]
        volume = ((wide + weights) * above + (wide - weights) * below).sum(axis=1) / dimension
    density: FloatArray = volume[0, 0]
    return density


def _sums(level: _Level, m: FloatArray, half: FloatArray, start: FloatArray) -> FloatArray:
    """(C, 2^j, d, B) what N'H f is with the fixed thrusters at their limits, the free ones amidst theirs."""
    moved = (m * half[:, None])[level.fixed]
    sums: FloatArray = start + np.einsum("sj,cjdb->csdb", level.signs, moved)
    return sums


def _pseudoinverses(level: _Level, m: FloatArray) -> FloatArray:
    """(C, n - j, d, B) M (M'M)^-1 of the free thrusters' rows M; 0 where they do not span."""
    M = m[level.free]
    gram = np.einsum("cpdb,cpeb->decb", M, M)
    size = np.einsum("ddcb->cb", gram) ** len(gram)
    P: FloatArray = np.einsum("cpdb,decb->cpeb", M, inverse(gram, 1e-18 * size.max(initial=0.0)))
    return P


def _segments(level: _Level, m: FloatArray, half: FloatArray, start: FloatArray) -> FloatArray:
    """(C, 2^j, B) lengths of the faces of one dimension, {t + s y}, in s."""
    n, d, _ = m.shape
    P, r = _pseudoinverses(level, m), _sums(level, m, half, start)
    # The free sets in order of their fixed ones are the (d + 1)-subsets backwards.
    y = dependencies(minors(m), n, d)[::-1]
    largest = np.abs(y).max(axis=1)
    spans = largest > 1e-9 * largest.max(initial=0.0)
    y = np.where(np.abs(y) < 1e-30, 1e-30, y)
    low, high = np.full(r[:, :, 0].shape, -np.inf), np.full(r[:, :, 0].shape, np.inf)
    for p in range(d + 1):
        centre = np.einsum("csdb,cdb->csb", r, P[:, p] / y[:, p, None])
        radius = (half[level.free[:, p]] / np.abs(y[:, p]))[:, None]
        low, high = np.maximum(low, centre - radius), np.minimum(high, centre + radius)
    lengths: FloatArray = np.where(spans[:, None], np.maximum(high - low, 0.0), 0.0)
    return lengths
