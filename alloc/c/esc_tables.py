"""The curves of ESCs as generated C has them: from full astern to full ahead, knots at whole steps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.vehicle.esc import Esc

CELLS = 128
"""Equal parts that thrusts of a curve are told apart by, half of them astern: a power of two. With 256 the
C of a T200 takes about 5 % fewer instructions and a fifth more flash."""
REACH = CELLS / 2 - 0.5
"""Cells that the largest thrust of a curve, ahead or astern, lies from 0."""
ROUNDING = 0.01
"""Share of a cell that rounding to float may move a thrust by."""


@dataclass(frozen=True, eq=False)
class SteppedCurve:
    """One curve, thrusts at whole steps.

    Attributes
    ----------
    steps : (K,) whole steps from neutral, rising
    f : (m, K) what they make at each voltage, never falling [N]
    jump : whether a thrust in the dead band may go to the smallest one
    """

    steps: IndexArray
    f: FloatArray
    jump: bool

    def first(self) -> IndexArray:
        """(m - 1 or 1, CELLS) the first piece that may hold a thrust of each cell, between two voltages.

        Thrust x lies in cell c = CELLS / 2 + REACH x / max(f_K, -f_1), rounded down. Between two voltages f
        is linear, so c of a knot is monotone while one end stays the larger: it is most at a voltage or where
        both ends are alike.
        """
        rows = []
        for a, b in zip(self.f, self.f[1:] if len(self.f) > 1 else self.f, strict=False):
            unlike = np.array([side[-1] + side[0] for side in (a, b)])
            alike = unlike[0] / (unlike[0] - unlike[1]) if unlike[0] * unlike[1] < 0 else 0.0
            at = a + np.array([0.0, alike, 1.0])[:, None] * (b - a)
            most = np.maximum(at[:, -1:], -at[:, :1])
            cell = (CELLS / 2 + np.divide(REACH * at, most, out=np.zeros_like(at), where=most > 0)).max(
                axis=0
            )
            least = np.arange(CELLS) - ROUNDING
            passed = (cell[1:, None] < least).sum(axis=0)
            passed[CELLS // 2] = (
                cell[1:] <= CELLS / 2
            ).sum()  # 0 is exact: a thrust ahead passes the dead band
            rows.append(np.minimum(passed, len(self.steps) - 2))
        return np.stack(rows)


@dataclass(frozen=True, eq=False)
class Tables:
    """Tables of a vehicle's ESCs, equal ones once.

    Attributes
    ----------
    volts : (m,) voltages of the rows [V]; one where all curves have one
    measured : first and last voltage at which all curves were measured, infinite where none says [V]
    curves : those that differ
    which : of each thruster its curve
    """

    volts: FloatArray
    measured: tuple[float, float]
    curves: list[SteppedCurve]
    which: list[int]

    @property
    def knots(self) -> int:
        """Number of knots of all curves."""
        return sum(len(curve.steps) for curve in self.curves)


def tables(escs: Sequence[Esc]) -> Tables:
    """The tables of n ESCs."""
    several = [esc.volts for esc in escs if len(esc.volts) > 1]
    volts = np.unique(np.concatenate(several)) if several else np.zeros(1)
    kinds: dict[object, tuple[int, SteppedCurve]] = {}
    which = []
    for esc in escs:
        curve = _curve(esc, volts)
        key = (esc.jump, curve.steps.tobytes(), curve.f.tobytes())
        which.append(kinds.setdefault(key, (len(kinds), curve))[0])
    said = [esc.volts for esc in escs if not np.isnan(esc.volts[0])]
    measured = max((v[0] for v in said), default=-np.inf), min((v[-1] for v in said), default=np.inf)
    return Tables(volts, measured, [curve for _, curve in kinds.values()], which)


def _curve(esc: Esc, volts: FloatArray) -> SteppedCurve:
    """An ESC's curve. Between whole steps no command can be sent, and none is a knot."""
    first, last = esc.ends
    along = (esc.command - esc.neutral) / esc.step
    whole = np.concatenate([np.floor(along), np.ceil(along), [first, 0, last]])
    steps = np.unique(np.clip(whole, first, last)).astype(np.intp)
    f = esc.made_at(steps, volts)
    idle: BoolArray = (f == 0).all(axis=0)
    within = np.concatenate([[False], idle[:-2] & idle[1:-1] & idle[2:], [False]])
    return SteppedCurve(steps[~within], f[:, ~within], esc.jump)
