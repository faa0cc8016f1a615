"""The exact answer of many layouts to many demands: the shortest z with lower <= A z <= upper.

The steps are those of the allocator ``nullspace`` (Seidel's, see docs/exact.md), taken for many calls at
once: rows of A one after the other; the calls whose z violates one go on to the plane of that row, one
dimension lower.
"""

import numpy as np

from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.vehicle import RANK_TOLERANCE


def nearest(
    A: FloatArray, lower: FloatArray, upper: FloatArray, slack: FloatArray, layout: IndexArray
) -> tuple[FloatArray, BoolArray]:
    """Shortest z (d, C) of C calls, and whether there is one (C,).

    Parameters
    ----------
    A : (m, d, B) one matrix a layout
    lower, upper : (m, C) limits of each call
    slack : (B,) by how much a limit may be missed and still count as met [unit of the limits]
    layout : (C,) which layout each call asks
    """
    m, d, _ = A.shape
    if d == 0:
        every = np.ones((m, len(slack)), dtype=bool)
        return np.zeros((0, len(layout))), _zeros_met(every, lower, upper, slack, layout)
    if d == 1:
        return _interval(A[:, 0], lower, upper, slack, layout)
    sizes = np.sqrt((A**2).sum(axis=1))
    flat = sizes <= RANK_TOLERANCE * sizes.max(axis=0, initial=0.0)
    met = _zeros_met(flat, lower, upper, slack, layout)
    z = np.zeros((d, len(layout)))
    moved = False  # whether any z has left zero
    for i in range(m):
        s = (A[i].take(layout, axis=1) * z).sum(axis=0) if moved else 0.0
        below = s < lower[i]
        out = np.flatnonzero((below | (s > upper[i])) & met)
        if flat[i].any():
            out = out[~flat[i, layout[out]]]
        if not out.size:
            continue
        base, along = _plane(A[i], sizes[i])
        shift = np.einsum("jdb,db->jb", A[:i], base)
        inside = np.einsum("jdb,deb->jeb", A[:i], along)
        lost = np.sqrt((inside**2).sum(axis=1)) <= RANK_TOLERANCE * sizes[:i]
        inside[np.broadcast_to(lost[:, None], inside.shape)] = 0.0
        of = layout[out]
        b = np.where(below[out], lower[i, out], upper[i, out])
        off = shift.take(of, axis=1) * b
        low, high = lower[:i].take(out, axis=1) - off, upper[:i].take(out, axis=1) - off
        y, met[out] = nearest(inside, low, high, slack, of)
        z[:, out] = base.take(of, axis=1) * b + (along.take(of, axis=2) * y).sum(axis=1)
        moved = True
    return z, met


def _interval(
    a: FloatArray, lower: FloatArray, upper: FloatArray, slack: FloatArray, layout: IndexArray
) -> tuple[FloatArray, BoolArray]:
    """Zero clamped into the interval that rows a (m, B) leave of one dimension."""
    flat = np.abs(a) <= RANK_TOLERANCE * np.abs(a).max(axis=0, initial=0.0)
    met = _zeros_met(flat, lower, upper, slack, layout)
    rate = np.where(flat, np.nan, 1.0 / np.where(flat, 1.0, a))
    largest, least = np.full(len(layout), -np.inf), np.full(len(layout), np.inf)
    for row, low, high in zip(rate, lower, upper, strict=True):
        scale = row[layout]
        p, q = low * scale, high * scale
        # fmin and fmax pass over NaN, which a row of zeros leaves.
        np.fmax(largest, np.minimum(p, q), out=largest)
        np.fmin(least, np.maximum(p, q), out=least)
    room = slack * np.nan_to_num(np.abs(rate)).max(axis=0, initial=0.0)
    met &= largest - least <= room[layout]
    return np.clip(0.0, largest, least)[None], met


def _zeros_met(
    flat: BoolArray, lower: FloatArray, upper: FloatArray, slack: FloatArray, layout: IndexArray
) -> BoolArray:
    """Whether each call's rows of zeros, ``flat`` (m, B), hold: they hold or fail whatever z is."""
    met = np.ones(len(layout), dtype=bool)
    for row in np.flatnonzero(flat.any(axis=1)):
        room = slack[layout]
        met &= ~flat[row, layout] | ((lower[row] <= room) & (upper[row] >= -room))
    return met


def _plane(a: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Of planes a'z = b, a (d, B): base (d, B), b base the nearest point, and (d, d - 1, B) what spans them.

    A Householder reflection turns a onto the first axis; its other columns span the plane.
    """
    size = np.where(size > 0, size, 1.0)
    mirror = a / size
    mirror[0] += np.where(mirror[0] < 0, -1.0, 1.0)
    square = np.maximum((mirror**2).sum(axis=0), 1.0)
    along = np.eye(len(a))[..., None] - (2.0 / square) * mirror[:, None] * mirror[None]
    return a / size**2, along[:, 1:]
