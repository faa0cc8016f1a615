"""The thruster configuration matrix T, from angles or from poses."""

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray

DOF = ("surge", "sway", "heave", "roll", "pitch", "yaw")
"""Order of the rows of a 6-DOF wrench [X, Y, Z, K, M, N], as in eq. 1."""


def planar_matrix(alpha_deg: ArrayLike, d: ArrayLike, phi_deg: ArrayLike) -> FloatArray:
    r"""T of thrusters in the horizontal plane, rows surge, sway, yaw.

    Column i is ``[cos a_i, sin a_i, d_i sin(a_i - phi_i)]`` (eq. 3; eq. 18 is its symmetric case).

    Parameters
    ----------
    alpha_deg : (n,) direction of each thrust from the longitudinal axis [deg]
    d : (n,) distance of each thruster from the centre of gravity [m]
    phi_deg : (n,) direction from the centre of gravity to each thruster [deg]

    Returns
    -------
    (3, n) matrix; rows 1-2 [-], row 3 [m]
    """
    alpha, phi = np.radians(alpha_deg), np.radians(phi_deg)
    return np.array([np.cos(alpha), np.sin(alpha), np.asarray(d) * np.sin(alpha - phi)])


def pose_matrix(
    positions: ArrayLike, directions: ArrayLike, center_of_mass: ArrayLike = (0.0, 0.0, 0.0)
) -> FloatArray:
    """T of thrusters at poses in the body frame, all six rows.

    Column i is ``[e_i; (r_i - r_cg) x e_i]`` (Fossen 2021, section 11.2), unit direction ``e_i``.

    Parameters
    ----------
    positions : (n, 3) where each thruster sits [m]
    directions : (n, 3) unit vectors along which positive thrust pushes the vehicle [-]
    center_of_mass : (3,) point about which moments are taken [m]

    Returns
    -------
    (6, n) matrix; rows surge, sway, heave [-], roll, pitch, yaw [m]
    """
    e = np.asarray(directions, dtype=float)
    arms = np.asarray(positions, dtype=float) - np.asarray(center_of_mass, dtype=float)
    return np.vstack([e.T, np.cross(arms, e).T])


def from_flu(vectors: ArrayLike) -> FloatArray:
    """Turn (…, 3) vectors from x forward, y left, z up (ROS) into x forward, y starboard, z down."""
    flipped: FloatArray = np.asarray(vectors, dtype=float) * np.array([1.0, -1.0, -1.0])
    return flipped
