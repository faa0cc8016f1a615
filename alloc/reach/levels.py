"""The way from thrusts at rest towards a demand, level by level: which step each level takes."""

from collections.abc import Sequence

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.vehicle import RANK_TOLERANCE, Vehicle

Levels = Sequence[Sequence[str]]
"""Axes, in levels; each axis of the vehicle stands in one of them."""

KEEP = 0.99
"""A level that others follow stops at this share of the way to the edge of the attainable set. On the very
edge what is left for later levels would jump between all and nothing with the last bit of a demand."""

OWN = 0.3
"""A direction belongs to a level where more than this share of its length lies on the level's axes. Then no
step moves other axes more than sqrt(1/OWN^2 - 1) = 3.2 times as far as its own, and none the axes of an
earlier level by more than OWN of its length. Below 1/sqrt(6) each direction belongs to one of at most six
levels. With one or two thrusters off and levels as their files have them, what arms of centimetres couple
lies at 0.05 or below, what shipped vehicles couple besides at 0.39 or above."""


def step_maps(vehicle: Vehicle, levels: Levels) -> FloatArray:
    """(L, k, k) matrices D: the step of a level from a wrench w is Delta = D (tau - w).

    Where the thrusters push every direction, D picks the level's axes, and the others stay. Where they don't,
    each direction that they push belongs to one level, the first on whose axes more than OWN of it lies, and
    Delta is the step in the level's own directions that brings its axes nearest to tau (axes in unit of
    ``row_lengths``). Later levels take nothing of that back, and all together reach each tau that can be
    pushed. With B an orthonormal basis of what the thrusters push, N one of the directions that earlier
    levels leave, S the rows of the level, and S B N = U diag(sigma) V' without the sigma up to OWN, that is
    D = B N V diag(1 / sigma) U' S.
    """
    axes = [[vehicle.dof.index(axis) for axis in level] for level in levels]
    maps = np.zeros((len(axes), vehicle.k, vehicle.k))
    if vehicle.rank == vehicle.k:
        for D, rows in zip(maps, axes, strict=True):
            D[rows, rows] = 1.0
        return maps
    unit = vehicle.row_lengths
    free = np.linalg.svd(vehicle.TP / unit[:, None])[0][:, : vehicle.rank]
    for D, rows in zip(maps, axes, strict=True):
        U, sigma, Vt = np.linalg.svd(free[rows])
        r = np.count_nonzero(sigma > OWN)
        D[:, rows] = free @ (Vt[:r].T / sigma[:r]) @ U[:, :r].T
        free = free @ Vt[r:].T
    maps[np.abs(maps) <= RANK_TOLERANCE] = 0.0
    return maps * (unit[:, None] / unit)


def keeps(vehicle: Vehicle, levels: Levels) -> list[float]:
    """Of each level the share of its way to the edge: all of it where no later level shares a thruster."""
    parts = [{*part} for part in groups(vehicle, vehicle.T)]
    reached = [{i for i, part in enumerate(parts) if part & {*level}} for level in levels]
    return [KEEP if any(own & later for later in reached[j + 1 :]) else 1.0 for j, own in enumerate(reached)]


def pushes(vehicle: Vehicle, T: FloatArray, least: float) -> BoolArray:
    """(k, n) which thrusters push which axis, by more than ``least`` of the length of its row of T [-]."""
    return np.abs(T) > least * vehicle.row_lengths[:, None]


def groups(
    vehicle: Vehicle, T: FloatArray | None = None, least: float = RANK_TOLERANCE
) -> tuple[tuple[str, ...], ...]:
    """The axes in groups that share no thruster, in the order of ``vehicle.dof``.

    The attainable set is the product of those of the groups, so no group's demand takes from another's. ``T``
    is the vehicle's with its faults, unless another is given; a thruster that pushes an axis by no more than
    ``least`` is not shared.
    """
    moved = pushes(vehicle, vehicle.TP if T is None else T, least)
    linked = (moved @ moved.T) | np.eye(vehicle.k, dtype=bool)
    connected = np.linalg.matrix_power(linked, vehicle.k)
    names = (tuple(vehicle.dof[i] for i in np.flatnonzero(row)) for row in connected)
    return tuple(dict.fromkeys(names))
