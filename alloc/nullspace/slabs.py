"""Limits of a vehicle whose thrusters turn as slabs of one block: fixed thrusters, then sides of polygons."""

from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.nullspace.structure import Structure
from alloc.vehicle import Vehicle


class Slabs(NamedTuple):
    """Limits low <= C f <= high of all thrusters that work.

    Two sides that are parallel are one slab. Of a side without such a twin the slab ends at the farthest
    corner, which keeps nothing out that other sides let in.

    Attributes
    ----------
    C : (m, n) rows of unit length [-]
    low, high : (m,) [N]
    """

    C: FloatArray
    low: FloatArray
    high: FloatArray


def polygon_slabs(vehicle: Vehicle) -> Slabs:
    """The slabs of a vehicle, those of fixed thrusters first."""
    turning = [i for azimuth in vehicle.turning for i in azimuth.components]
    fixed = [i for i in vehicle.working.tolist() if i not in turning]
    rows, low, high = [np.eye(vehicle.n)[fixed]], [vehicle.f_min[fixed]], [vehicle.f_max[fixed]]
    for azimuth in vehicle.turning:
        across = np.zeros((len(azimuth.distinct), vehicle.n))
        across[:, azimuth.components] = azimuth.normals[azimuth.distinct]
        along = across[:, azimuth.components] @ azimuth.corners.T
        rows.append(across)
        low.append(along.min(axis=1))
        high.append(along.max(axis=1))
    return Slabs(np.vstack(rows), np.concatenate(low), np.concatenate(high))


def whole_basis(structure: Structure, n: int) -> FloatArray:
    """N (n, d) of all blocks side by side."""
    N, end = np.zeros((n, sum(block.N.shape[1] for block in structure.blocks))), 0
    for block in structure.blocks:
        end += block.N.shape[1]
        N[block.rows, end - block.N.shape[1] : end] = block.N
    return N
