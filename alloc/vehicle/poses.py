"""Positions and directions of thrusters, from any geometry that a vehicle file gives."""

from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.vehicle.columns import possible
from alloc.vehicle.file import reaction_torques
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import VehicleFile


class Mounting(NamedTuple):
    """Mounting of n thrusters, in the frame of their vehicle.

    Attributes
    ----------
    positions : (n, 3) from the origin of the file [m]
    directions : (n, 3) along which positive thrust pushes the vehicle; shorter than 1 where T leaves out a
        part of it, 0 for a thruster that gives no force [-]
    center : (3,) the centre of mass [m]
    measured : whether the file gives positions; else they are the nearest to the centre of mass of all that
        make the same T
    stands : (n,) whether there is such a line of thrust; else position and direction say nothing
    """

    positions: FloatArray
    directions: FloatArray
    center: FloatArray
    measured: bool
    stands: BoolArray


def poses(keys: VehicleFile, T: FloatArray) -> Mounting:
    """The poses of a file's thrusters, with T (k, n) as ``matrices`` makes it of the same file.

    A T without poses tells the line along which a thruster pushes, not where on that line it sits: of
    force e and moment m, the point of the line that is nearest to the centre of mass is e x m / |e|^2.
    """
    all_stand = np.ones(T.shape[1], dtype=bool)
    if keys.thrusters:
        positions = np.array([thruster.position for thruster in keys.thrusters])
        directions = np.array([thruster.direction for thruster in keys.thrusters])
        return Mounting(positions, directions, np.array(keys.center_of_mass), True, all_stand)
    if keys.planar is not None:
        alpha, phi = np.radians(keys.planar.alpha_deg), np.radians(keys.planar.phi_deg)
        zero = np.zeros(len(alpha))
        positions = np.array(keys.planar.d) * np.array([np.cos(phi), np.sin(phi), zero])
        directions = np.array([np.cos(alpha), np.sin(alpha), zero])
        return Mounting(positions.T, directions.T, np.zeros(3), True, all_stand)
    whole = np.zeros((6, T.shape[1]))
    whole[[DOF.index(axis) for axis in keys.dof]] = T
    force, moment = whole[:3].T, whole[3:].T
    squared = (force**2).sum(axis=1, keepdims=True)
    nearest = np.cross(force, moment) / np.where(squared > 0, squared, 1.0)
    stands = possible(T, keys.dof, reaction_torques(keys, T.shape[1])) & (squared[:, 0] > 0)
    return Mounting(nearest, force, np.zeros(3), False, stands)
