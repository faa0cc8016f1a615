"""What layouts can do, whole and after failures, and how small a demand must be for the closed form."""

from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.vehicle import RANK_TOLERANCE
from bench.layouts.minors import subsets
from bench.layouts.spaces import Layouts, Spaces

ROUNDING = 1e-12
"""What counts as zero of a unit normal, as in ``alloc.alpha_max``."""

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
    """How far layouts push.

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
    """(B,) ``alloc.safe_share``: the largest s <= 1 for which the closed form meets s tau, tau attainable."""
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
