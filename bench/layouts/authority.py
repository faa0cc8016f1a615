"""Volumes that layouts reach and that closed forms reach, whole and after each failure."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.vehicle import RANK_TOLERANCE
from bench.layouts.spaces import Layouts, Spaces, dependencies, inverse, minors, subsets

ROUNDING = 1e-12
"""Size that counts as zero in a unit normal, as in ``alloc.alpha_max``."""

FLAT = 1e-9
"""Minors of an orthonormal basis below this count as zero: their thrusters span no facet."""

TIE = 9
"""Decimals of the largest volume to which volumes are compared: symmetric thrusters differ by rounding."""


class Volumes(NamedTuple):
    """Volumes of attainable sets, 0 where rank is lost [N^k, in the unit of T's moment arms].

    Attributes
    ----------
    whole : (B,) with all thrusters
    after_one : (n, B) without each thruster
    after_two : (n (n - 1) / 2, B) without each pair, in the order of ``subsets``
    """

    whole: FloatArray
    after_one: FloatArray
    after_two: FloatArray


def volumes(layouts: Layouts, found: Spaces) -> Volumes:
    """Exact volumes: sum over the k thrusters I that span a tile of |det T_I| times their widths.

    The tiles that are left after failures are those whose other d thrusters include the failed ones.
    """
    n, d = found.n, found.d
    members = subsets(n, d)
    width = layouts.f_max - layouts.f_min
    tiles = found.content * np.abs(found.minors) * width.prod(axis=0)
    for p in range(d):
        tiles = tiles / width[members[:, p]]
    other = np.zeros((n, len(members)))  # thruster, tile: whether the tile does without the thruster
    other[members.T, np.arange(len(members))] = 1.0
    pairs = subsets(n, 2)
    return Volumes(tiles.sum(axis=0), other @ tiles, (other[pairs[:, 0]] * other[pairs[:, 1]]) @ tiles)


class WorstFailure(NamedTuple):
    """The worst failure of one thruster, or of two.

    Attributes
    ----------
    which : (B,) index of the thruster, or of the pair in the order of ``subsets``
    rank : (B,) what is left
    volume : (B,) what is left, 0 where rank is lost
    condition : (B,) largest over smallest singular value, NaN where rank is lost
    """

    which: IndexArray
    rank: IndexArray
    volume: FloatArray
    condition: FloatArray


def worst_faults(layouts: Layouts, found: Spaces, after: Volumes) -> tuple[WorstFailure, WorstFailure | None]:
    """The worst single failure and the worst double one: the lowest rank first, then the least volume.

    Without thrusters S the rank is k - |S| + rank N_S, N the null-space basis: what a thruster adds is lost
    where nothing can stand in for it. None for a double failure that leaves no thruster.
    """
    k, n, _ = layouts.T.shape
    basis = found.N * np.sqrt(layouts.weights)[:, None]  # rows compare in size whatever H is
    gram = np.einsum("idb,jdb->ijb", basis, basis)
    alone = np.einsum("iib->ib", gram)
    single = _worst(layouts, subsets(n, 1), k - (np.sqrt(alone) <= FLAT), after.after_one, after.whole)
    if n < 3:
        return single, None
    i, j = subsets(n, 2).T
    area = alone[i] * alone[j] - gram[i, j] ** 2
    kept = np.where(area > ROUNDING * alone[i] * alone[j], 2, 0)
    kept = np.where((kept == 0) & (np.maximum(alone[i], alone[j]) > FLAT**2), 1, kept)
    return single, _worst(layouts, subsets(n, 2), k - 2 + kept, after.after_two, after.whole)


def _worst(
    layouts: Layouts, failures: IndexArray, ranks: IndexArray, left: FloatArray, whole: FloatArray
) -> WorstFailure:
    share = (left / whole).round(TIE)
    which = np.argmin(ranks + share / 2, axis=0)  # ranks differ by 1 or more, half a share by less
    columns = np.arange(len(layouts))
    off = np.zeros(layouts.weights.shape, dtype=bool)
    for members in failures[which].T:
        off[members, columns] = True
    rank = ranks[which, columns]
    full = rank == len(layouts.T)
    sigma = layouts.singular_values(off)
    condition = np.where(full, sigma[0] / np.where(full, sigma[-1], 1.0), np.nan)
    return WorstFailure(which, rank, np.where(full, left[which, columns], 0.0), condition)


class Reach(NamedTuple):
    """Reach of layouts.

    Attributes
    ----------
    axis_min, axis_max : (k, B) largest wrench backward and forward along each axis alone [N, N m]
    any_direction : (B,) what is attainable in every direction, |tau / scale| [unit of tau / scale]
    """

    axis_min: FloatArray
    axis_max: FloatArray
    any_direction: FloatArray


def reach(layouts: Layouts, found: Spaces, scale: FloatArray) -> Reach:
    """Largest wrenches: the least support(c) / c'tau over the facets of the attainable set.

    The normal c of a facet is at right angles to k - 1 thrusters, so c'T = y has d + 1 entries that are
    not zero, and y N = 0 says which; c = G'y. ``scale`` (k,) says which wrenches count as equally long.
    """
    members, y = subsets(found.n, found.d + 1), found.dependencies
    middle, half = (layouts.f_max + layouts.f_min) / 2, (layouts.f_max - layouts.f_min) / 2
    normals = np.zeros((len(layouts.T), *y[:, 0].shape))
    centre, width = np.zeros(y[:, 0].shape), np.zeros(y[:, 0].shape)
    for p, rows in enumerate(members.T):
        centre += middle[rows] * y[:, p]
        width += half[rows] * np.abs(y[:, p])
        normals += found.G[rows].swapaxes(0, 1) * y[:, p]
    forward, backward = width + centre, width - centre
    flat = np.abs(y).max(axis=1) <= FLAT
    forward[flat] = backward[flat] = np.inf
    length = np.sqrt(np.einsum("kfb,kfb->fb", normals, normals * layouts.row_lengths[:, None] ** 2))
    largest, smallest = np.empty(normals[:, 0].shape), np.empty(normals[:, 0].shape)
    for axis, normal in enumerate(normals):
        along = np.abs(normal)
        along[along * layouts.row_lengths[axis] <= ROUNDING * length] = 0.0
        ahead = normal > 0
        with np.errstate(divide="ignore", invalid="ignore"):
            largest[axis] = np.nanmin(np.where(ahead, forward, backward) / along, axis=0)
            smallest[axis] = np.nanmin(np.where(ahead, backward, forward) / along, axis=0)
    size = np.sqrt(np.einsum("kfb,kfb->fb", normals, normals * scale[:, None, None] ** 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        every = np.nanmin(np.minimum(forward, backward) / size, axis=0)
    return Reach(-smallest, largest, every)


def safe_shares(layouts: Layouts, found: Spaces) -> FloatArray:
    """(B,) largest s <= 1 for which T* s tau keeps limits: ``alloc.reach.volumes.safe_share`` of each."""
    scale = np.maximum(np.abs(layouts.f_min), np.abs(layouts.f_max)).max(axis=0)
    share = np.ones(len(layouts))
    heavy = found.N * layouts.weights[:, None]
    for i, row in enumerate(found.N):
        kept = -np.einsum("db,jdb->jb", row, heavy)  # row i of T* T = I - N N'H
        kept[i] += 1.0
        ends = kept * layouts.f_min, kept * layouts.f_max
        for asked, limit in (
            (np.maximum(*ends).sum(axis=0), layouts.f_max[i]),
            (np.minimum(*ends).sum(axis=0), layouts.f_min[i]),
        ):
            counts = np.abs(asked) > RANK_TOLERANCE * scale
            share = np.minimum(share, np.where(counts, limit / np.where(counts, asked, 1.0), 1.0))
    return np.maximum(share, 0.0)


def unannounced_shares(layouts: Layouts, found: Spaces, scale: FloatArray) -> FloatArray:
    """(B,) share of a wrench that T* tau delivers at worst while one thruster is off and nobody knows [-].

    Thruster i takes T_i G_i tau of it, at most |T_i| |G_i| of its length; lengths over ``scale`` (k,). Below
    0 what is missed is longer than the demand.
    """
    pushed = np.linalg.norm(layouts.T / scale[:, None, None], axis=0)
    asked = np.linalg.norm(found.G * scale[:, None], axis=1)
    share: FloatArray = 1.0 - (pushed * asked).max(axis=0)
    return share


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
