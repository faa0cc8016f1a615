"""The thruster configuration matrix T, from angles or from poses."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import BoolArray, FloatArray
from alloc.vehicle.frame import turned

DOF = ("surge", "sway", "heave", "roll", "pitch", "yaw")
"""Order of the rows of a 6-DOF wrench [X, Y, Z, K, M, N], as in eq. 1."""
MOMENTS = ("roll", "pitch", "yaw")


def unit(axis: str) -> str:
    """The unit of a wrench along an axis: ``N`` or ``N m``."""
    return "N m" if axis in MOMENTS else "N"


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
    positions: ArrayLike,
    directions: ArrayLike,
    center_of_mass: ArrayLike = (0.0, 0.0, 0.0),
    reaction_torque: ArrayLike = 0.0,
) -> FloatArray:
    """T of thrusters at poses, all six rows, in the frame of the poses; any right-handed one.

    Column i is ``[e_i; (r_i - r_cg) x e_i + m_i e_i]`` (Fossen 2021, section 11.2), unit direction ``e_i``.

    Parameters
    ----------
    positions : (n, 3) where each thruster sits [m]
    directions : (n, 3) unit vectors along which positive thrust pushes the vehicle [-]
    center_of_mass : (3,) point about which moments are taken [m]
    reaction_torque : (n,) or one number, the propeller's own moment along e_i for 1 N [m]

    Returns
    -------
    (6, n) matrix; rows surge, sway, heave [-], roll, pitch, yaw [m]
    """
    e = np.asarray(directions, dtype=float)
    arms = np.asarray(positions, dtype=float) - np.asarray(center_of_mass, dtype=float)
    return np.vstack([e.T, np.cross(arms, e).T + reaction_torque * e.T])


def contradictions(
    given: FloatArray, computed: FloatArray, dof: Sequence[str], names: Sequence[str]
) -> list[str]:
    """One sentence for each row in which a given T (k, n) differs from the T (k, n) that its poses make.

    Entries may differ by 1 % of the row's largest, since published matrices are printed to two or
    three digits; a given entry is shown as its file has it. A row with flipped sign and a T in the other
    frame have sentences of their own. ``names``
    are what the thrusters are called.
    """
    scale = np.abs(computed).max(axis=1).clip(min=np.abs(computed).max() * 1e-3)[:, None]

    def differ(A: FloatArray, B: FloatArray) -> BoolArray:
        wrong: BoolArray = np.abs(A - B) > 0.01 * scale
        return wrong

    wrong = differ(given, computed)
    if wrong.any() and not differ(given, turned(computed, dof)).any():
        return ["T and the poses are in different frames (one has z down, the other z up)"]
    sentences = []
    for i, axis in enumerate(dof):
        if not wrong[i].any():
            continue
        if not differ(-given, computed)[i].any():
            sentences.append(f"the {axis} row has the opposite sign of what the poses make")
            continue
        j = int(np.argmax(np.abs(given - computed)[i]))
        sentences.append(
            f"{axis} of {names[j]} is {given[i, j]:.10g}, but its pose makes {computed[i, j]:.4g} "
            f"({int(wrong[i].sum())} of {given.shape[1]} thrusters differ)"
        )
    return sentences
