"""The thruster configuration matrix T from angles or poses, and columns that no thruster can make.

A thrust along a line at r, in direction d, makes the column [d; r x d], so force . moment = 0, in every frame
and about every point. A propeller adds its own moment along d: [d; r x d + m d], force . moment = m |d|^2.
"""

from collections.abc import Sequence
from typing import NamedTuple

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


LEAST = 1e-3
"""Share of |force| |moment| that counts as none: published directions have three digits, and not every number
of a file is printed to as many as the longest."""
ALIKE = 0.05
"""Share by which propellers of one kind may differ in their own moments."""
LONGEST = 0.2
"""Longest moment for its thrust that is taken for a propeller's own [m]: about that of one a metre wide, and
below the arms of thrusters, which a transposed T has there."""
MOST_DIGITS = 6
"""Decimals up to which a number is shown as the file has it; more come from a program."""

IMAGES = {
    "": (1, 1, 1, 1, 1, 1),
    ", mirrored in the plane xz": (1, -1, 1, -1, 1, -1),
    ", mirrored in the plane yz": (-1, 1, 1, 1, -1, -1),
    ", turned by 180 degrees about z": (-1, -1, 1, -1, -1, 1),
    ", mirrored in the plane xy": (1, 1, -1, -1, -1, 1),
}
"""Signs of a column's image: a mirror turns the force's part across it, and the moment's parts along it."""


class Along(NamedTuple):
    """Part of each column's moment that lies along its own thrust.

    Attributes
    ----------
    moment : (n,) force . moment / |force|^2 [m]; NaN where rows that T leaves out could make it anything
    rounding : (n,) how much of that the rounding of printed digits explains [m]
    """

    moment: FloatArray
    rounding: FloatArray


def along_thrust(T: FloatArray, dof: Sequence[str]) -> Along:
    """The part of each column's moment that no line of thrust makes; T (k, n) in any frame."""
    whole, known = _six_rows(T, dof)
    half = _half_digits(T, dof)
    force, moment = whole[:3], whole[3:]
    # A product is unknown where both factors are left out of T, and where one is and the other is not zero.
    open_ = ~known[:3] & (~known[3:] | (np.abs(moment) > half[3:]))
    open_ |= ~known[3:] & (np.abs(force) > half[:3])
    squared = (force**2).sum(axis=0)
    certain = ~open_.any(axis=0) & (squared > 0)
    over = np.where(certain, squared, 1.0)
    sizes = np.linalg.norm(force, axis=0) * np.linalg.norm(moment, axis=0)
    doubt = (np.abs(force) * half[3:] + np.abs(moment) * half[:3] + half[:3] * half[3:]).sum(axis=0)
    return Along(
        np.where(certain, (force * moment).sum(axis=0) / over, np.nan), (doubt + LEAST * sizes) / over
    )


def possible(T: FloatArray, dof: Sequence[str], reaction_torque: FloatArray) -> BoolArray:
    """(n,) whether a line of thrust, with the propeller's own moment (n,) [m], can make each column of T."""
    moment, rounding = along_thrust(T, dof)
    result: BoolArray = ~(np.abs(moment - reaction_torque) > rounding)  # true where it is not known
    return result


def alike(T: FloatArray, dof: Sequence[str]) -> float:
    """The moment along its own thrust that all columns have, turning either way [m]; 0 where they differ.

    Propellers of one kind explain such moments, wrong signs hardly.
    """
    moment, rounding = along_thrust(T, dof)
    known = ~np.isnan(moment)
    sizes, doubt = np.abs(moment[known]), rounding[known]
    if len(sizes) < 2 or not (sizes > doubt).all():
        return 0.0
    typical = float(np.median(sizes))
    near = (np.abs(sizes - typical) <= ALIKE * typical + doubt).all()
    return typical if near and typical < LONGEST else 0.0


def refusals(
    T: FloatArray, dof: Sequence[str], reaction_torque: FloatArray, names: Sequence[str]
) -> dict[int, str]:
    """By thruster, a sentence on each column that none can make: its numbers, the suspect, the remedy."""
    sound = possible(T, dof, reaction_torque)
    if sound.all() or (alike(T, dof) and not reaction_torque.any()):
        return {}
    moment = along_thrust(T, dof).moment
    sentences = {}
    for i in np.flatnonzero(~sound).tolist():
        numbers = ", ".join(
            f"{axis} {entry_text(T, dof, row, i)}" for row, axis in enumerate(dof) if T[row, i]
        )
        product = moment[i] * (T[_forces(dof), i] ** 2).sum()
        sentences[i] = (
            f"{names[i]} ({numbers}): force · moment = {product:.3g} m, expected 0;"
            f" {_suspect(T, dof, i, sound, names)}. If this is propeller torque, set reaction_torque:"
            f" {moment[i]:.3g} for it"
        )
    return sentences


def decimals(values: FloatArray) -> int:
    """The most decimals that any of the numbers is written with."""
    texts = (np.format_float_positional(value, trim="-") for value in np.unique(values))
    return max(len(text.partition(".")[2]) for text in texts)


def entry_text(T: FloatArray, dof: Sequence[str], row: int, column: int) -> str:
    """An entry of T with the decimals that its file has."""
    digits = decimals(T[_rows_like(dof, row)])
    value = T[row, column] + 0.0
    return f"{value:.{digits}f}" if digits <= MOST_DIGITS else f"{value:.4g}"


def _suspect(T: FloatArray, dof: Sequence[str], i: int, sound: BoolArray, names: Sequence[str]) -> str:
    """Sign that is wrong: with the opposite sign the column is a twin's image, or at least possible.

    Arms are in doubt before directions, since a direction is seen on the vehicle.
    """
    mending: list[int] = []
    for row in sorted(np.flatnonzero(T[:, i]).tolist(), key=lambda row: dof[row] not in MOMENTS):
        mended = T.copy()
        mended[row, i] *= -1
        if not possible(mended, dof, np.zeros(T.shape[1]))[i]:
            continue
        mending.append(row)
        for j in np.flatnonzero(sound).tolist():
            for words, six in IMAGES.items():
                image = np.array([six[DOF.index(axis)] for axis in dof]) * T[:, j]
                if _twins(image, mended[:, i], T) or _twins(-image, mended[:, i], T):
                    return (
                        f"{dof[row]} is the suspect: with {_negated(T, dof, row, i)} it would go with"
                        f" {names[j]}{words}"
                    )
    axes = [dof[row] for row in mending if dof[row] in MOMENTS]
    return f"the other sign of {' or '.join(axes)} would mend it" if axes else "no single sign mends it"


def _twins(a: FloatArray, b: FloatArray, T: FloatArray) -> bool:
    """True if two columns have the same signs, and the same sizes but for one arm."""
    apart = np.abs(a - b) > 0.01 * np.abs(T).max(axis=1)
    return bool((a * b >= 0).all() and apart.sum() <= 1 and ((a == 0) == (b == 0)).all())


def _negated(T: FloatArray, dof: Sequence[str], row: int, column: int) -> str:
    text = entry_text(T, dof, row, column)
    return text[1:] if text.startswith("-") else f"-{text}"


def _six_rows(T: FloatArray, dof: Sequence[str]) -> tuple[FloatArray, BoolArray]:
    """T with all six rows, 0 in those that it leaves out; and (6, 1) which it has."""
    rows = [DOF.index(axis) for axis in dof]
    whole, known = np.zeros((6, T.shape[1])), np.zeros((6, 1), dtype=bool)
    whole[rows], known[rows] = T, True
    return whole, known


def _half_digits(T: FloatArray, dof: Sequence[str]) -> FloatArray:
    """(6, 1) half of the last printed digit of the force rows and of the moment rows."""
    half = np.zeros((6, 1))
    for row, axis in enumerate(dof):
        half[DOF.index(axis)] = 0.5 * 10.0 ** -decimals(T[_rows_like(dof, row)])
    return half


def _forces(dof: Sequence[str]) -> list[int]:
    return [row for row, axis in enumerate(dof) if axis not in MOMENTS]


def _rows_like(dof: Sequence[str], row: int) -> list[int]:
    """The force rows, or the moment rows: a file prints all of them to the same digits."""
    return [i for i, axis in enumerate(dof) if (axis in MOMENTS) == (dof[row] in MOMENTS)]
