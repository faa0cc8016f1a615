"""Weak directions: those along which a vehicle can do no more than its survey could have made of nothing.

With A = D^-1 T P diag(max |f|), D = 1 for forces and the rms arm of the whole vehicle's thrusters for
moments, a left singular vector u of A has the authority sigma, its singular value. Poses that are off by the
survey's tolerance change T by dT; epsilon(u) is the root mean square of |u' D^-1 dT P diag(max |f|)|. A
direction is weak where sigma <= WEAK epsilon(u); one that no thruster pushes is the limit case. Six- and
eight-thruster BlueROV2 and a hexarotor, none, one or two thrusters off, 40 surveys each (3 mm, 0.3 deg; 5 mm,
0.5 deg): lost directions have sigma / epsilon up to 1.6, all others 6.7 and more.
sigma / sigma_max does not separate them: a healthy hexarotor's yaw has 0.021, a surveyed BlueROV2's pitch
up to 0.039. Between WEAK and twice that a direction counts in part, so that no share has a step in sigma.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import VehicleError
from alloc.vehicle.degeneracy import ROUNDED
from alloc.vehicle.geometry import DOF, MOMENTS

WEAK = 2.0
"""Largest sigma / epsilon of a weak direction."""
RELATIVE = 0.01
"""Tolerance of an entry of T that is no thrust along a line, relative to the largest of its row [-]."""
UNIT = 1e-3
"""Share by which the force of a column may differ from the largest if it is that of a pose: published
directions carry three digits."""
SHORT = 0.24
"""Shortest row of T that counts with its own length among others, relative to a row of the rms [-]. A
demand is projected in rows of one length, and a pitch of millimetres must not weigh as much as surge: shorter
rows count as longer, up to one of the rms for a row of nothing. No shipped vehicle has a row this short.
Rows of D alone (the rms for each) would do as well there, but a vehicle that loses a direction would get
another wrench than its drawing, whose rows count with their own lengths."""
MOST = 0.5
"""Largest sigma / sigma_max that a file may call weak: half of what the vehicle does best is not weak."""

ALL_WEAK = (
    "every direction is weak: the thrusters push no more than the survey could make of nothing; give a finer"
    " 'survey', or 'weak: 0'"
)


@dataclass(frozen=True)
class Survey:
    """Tolerance to which a vehicle's geometry is known.

    Attributes
    ----------
    mm, deg : of positions along each axis [mm] and of directions about each axis [deg]
    relative : of each entry of T, relative to the largest of its row [-]; None where poses are surveyed
    """

    mm: float = 3.0
    deg: float = 0.3
    relative: float | None = None

    def __post_init__(self) -> None:
        """Raise VehicleError for a tolerance that is negative or no number."""
        for key in ("mm", "deg", "relative"):
            value = getattr(self, key)
            if value is not None and not 0.0 <= value < np.inf:
                raise VehicleError(f"survey: {key} is {value:g}; give a tolerance of 0 or more", "survey")

    @property
    def words(self) -> str:
        """``3 mm, 0.3 deg`` or ``1 % of T``."""
        return (
            f"{self.mm:g} mm, {self.deg:g} deg"
            if self.relative is None
            else f"{100 * self.relative:g} % of T"
        )


DRAWN = Survey()
"""A tape measure's: of a vehicle that says nothing."""


ALIKE = 0.99
"""The sign of a direction is that of its first entry that is as long as this share of the longest [-]."""


class Directions(NamedTuple):
    """Directions of wrench, from the one with the most authority to the one with the least.

    Attributes
    ----------
    rows : (k, k) c of each, so that c'tau is the part of a wrench along it; |c D| = 1
    sigma : (k,) authority, 0 where no thruster pushes [N]
    epsilon : (k,) authority that the survey's tolerance may make of nothing [N]
    scale : (k,) D
    """

    rows: FloatArray
    sigma: FloatArray
    epsilon: FloatArray
    scale: FloatArray

    def counts(self, rank: int, below: float | None) -> FloatArray:
        """(k,) share w to which each counts: 0 of a weak one, 1 from twice the largest weak sigma on [-].

        Between, w is linear in sigma. Those beyond the rank are weak; ``below`` as ``Vehicle.weak_limit``.
        """
        found = count_shares(self.sigma, WEAK * self.epsilon if below is None else below * self.sigma[:1])
        found[rank:] = 0.0
        return found

    def strong_rows(
        self, T: FloatArray, own: FloatArray, weak: IndexArray, working: IndexArray
    ) -> tuple[FloatArray, FloatArray]:
        """T (k, n) whose ``working`` columns push nothing along the directions ``weak``; lengths of its rows.

        Rows count with their own lengths, ``own`` (k,) of T, or where these are SHORT with longer ones.
        Thrusters that are off count as on the drawing, so that failures change no length.
        """
        A, U = T / self.scale[:, None], (self.rows[weak] * self.scale).T
        rms = np.linalg.norm(A) / np.sqrt(2.0) * self.scale
        if not len(weak):
            return T, _lengths(own, rms)
        strong = A[:, working] - U @ (U.T @ A[:, working])
        strong[np.abs(strong) <= ROUNDED * np.abs(A).max()] = 0.0
        whole = T.copy()
        whole[:, working] = strong * self.scale[:, None]
        return whole, _lengths(np.linalg.norm(whole, axis=1), rms)


def count_shares(sizes: FloatArray, largest: FloatArray) -> FloatArray:
    """Share to which each size counts: 0 up to the ``largest`` that is weak, 1 from twice that on [-]."""
    times = np.divide(sizes, largest, out=np.full(sizes.shape, np.inf), where=largest > 0.0)
    found: FloatArray = np.clip(times - 1.0, 0.0, 1.0)
    return found


def couplings(sizes: FloatArray, largest: FloatArray) -> FloatArray:
    """Share to which each entry couples its axis: 0 up to 3/2 of the ``largest`` weak one, 1 from 2 on [-].

    A direction averages the errors of many entries, and noise alone seldom takes it beyond WEAK. It takes one
    entry in thirty there, next to none beyond 3/2 of that, and a mixture costs as much as two answers.
    """
    return np.clip(2.0 * count_shares(sizes, largest) - 1.0, 0.0, 1.0)


def _lengths(own: FloatArray, rms: FloatArray) -> FloatArray:
    """Lengths (k,) that rows count with: their own, or below SHORT longer ones, up to the rms for nothing."""
    return np.where(own < SHORT * rms, rms - own * (1.0 - SHORT) / SHORT, own)


def omissions(counts: FloatArray) -> list[tuple[float, IndexArray]]:
    """Indices of the directions that each vehicle of ``Vehicle.mixture`` leaves out, and its w [-]."""
    weak, between = np.flatnonzero(counts == 0.0), np.flatnonzero((counts > 0.0) & (counts < 1.0))
    between = between[np.argsort(-counts[between], kind="stable")]
    if len(between) + len(weak) == len(counts):  # something must count
        between = between[1:]
    each = [np.sort(np.concatenate((weak, between[j:]))) for j in range(len(between) + 1)]
    return list(zip((1.0, *counts[between].tolist()), each, strict=True))


def check_limit(name: str, below: float | None) -> None:
    """Raise VehicleError for a limit of sigma / sigma_max that is none."""
    if below is not None and not 0.0 <= below <= MOST:
        raise VehicleError(
            f"{name}: weak is {below:g}; give auto, or sigma / sigma_max from 0 (never) to {MOST:g}", "weak"
        )


def axis_scale(T: FloatArray, dof: Sequence[str]) -> FloatArray:
    """(k,) D: 1 for forces, the rms arm of the thrusters for moments [m]."""
    moments = np.isin(dof, MOMENTS)
    force, moment = (float(np.linalg.norm(T[rows])) for rows in (~moments, moments))
    arm = moment / force if force > 0.0 and moment > 0.0 else 1.0
    return np.where(moments, arm, 1.0)


def directions(
    T: FloatArray,
    readiness: FloatArray,
    far: FloatArray,
    dof: Sequence[str],
    survey: Survey,
    poses: FloatArray | None = None,
) -> Directions:
    """The directions of T P diag(far) and what a survey makes of them; far (n,) is max |f| [N]."""
    whole = six_rows(T, dof, poses)
    scale = axis_scale(whole, DOF)[[DOF.index(axis) for axis in dof]]
    weight = readiness * far
    U, s, _ = np.linalg.svd(T * weight / scale[:, None])
    sigma = np.zeros(len(T))
    sigma[: len(s)] = s
    sign = np.sign([u[np.abs(u) >= ALIKE * np.abs(u).max()][0] for u in U.T])  # LAPACK's is by chance
    rows = (sign * U).T / scale
    squares = doubts(T, dof, survey, rows, whole)
    return Directions(rows, sigma, np.sqrt(squares @ weight**2), scale)


def six_rows(T: FloatArray, dof: Sequence[str], poses: FloatArray | None = None) -> FloatArray:
    """(6, n) columns of all axes: those of ``poses`` that make T (k, n) to RELATIVE, else T and zeros."""
    rows, whole = [DOF.index(axis) for axis in dof], np.zeros((6, T.shape[1]))
    whole[rows] = T
    if poses is None:
        return whole
    apart = np.abs(poses[rows] - T) > RELATIVE * np.abs(T).max(axis=1, keepdims=True)
    known: FloatArray = np.where(apart.any(axis=0), whole, poses)
    return known


def doubts(
    T: FloatArray, dof: Sequence[str], survey: Survey, rows: FloatArray, poses: FloatArray | None = None
) -> FloatArray:
    """(m, n) mean square of c'dT_i for rows c (m, k), by linear propagation of uniform errors.

    A column of unit force e and moment m is a thrust at r = e x m, with a moment p e of its own. Turned
    by theta and moved by dr it changes by [theta x e; dr x e + r x (theta x e) + p theta x e], so with
    c = [a; b]

        c'dT = theta'(e x (a + b x r + p b)) + dr'(e x b)

    Axes that are not controlled count where ``poses`` (6, n) tell them. Where all three forces are
    controlled, thrusts may have another unit: e has then the length of the longest column. Other columns err
    by the relative tolerance.
    """
    whole, c = six_rows(T, dof, poses), np.zeros((len(rows), 6))
    c[:, [DOF.index(axis) for axis in dof]] = rows
    forces = np.linalg.norm(whole[:3], axis=0)
    unit = float(forces.max()) if {*DOF[:3]} <= {*dof} and forces.any() else 1.0
    e, m = whole[:3].T / unit, whole[3:].T / unit
    a, b = c[:, None, :3], c[:, None, 3:]
    own = np.einsum("ij,ij->i", e, m)[None, :, None]
    turned = np.cross(e, a + np.cross(b, np.cross(e, m)) + own * b)
    by_pose = (
        unit**2
        * (
            np.radians(survey.deg) ** 2 * (turned**2).sum(axis=2)
            + (1e-3 * survey.mm) ** 2 * (np.cross(e, b) ** 2).sum(axis=2)
        )
        / 3.0
    )
    share = RELATIVE if survey.relative is None else survey.relative
    by_entry = ((rows * share * np.abs(T).max(axis=1)) ** 2).sum(axis=1, keepdims=True) / 3.0
    posed = (np.abs(forces / unit - 1.0) <= UNIT) & (survey.relative is None)
    found: FloatArray = np.where(posed, by_pose, by_entry)
    return found
