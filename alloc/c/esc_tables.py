"""The curves of ESCs as generated C has them: sides one after the other, knots at whole steps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.vehicle.esc import Esc

BUCKETS = 64
"""Places where a walk along a side of a curve may begin, a power of two: more make it shorter."""


@dataclass(frozen=True, eq=False)
class CurveSide:
    """One side of a curve, sizes of thrusts at whole steps.

    Attributes
    ----------
    steps : (K,) whole steps from neutral, rising; the first makes nothing
    f : (m, K) what they make at each voltage [N]
    """

    steps: IndexArray
    f: FloatArray

    def start(self) -> IndexArray:
        """(BUCKETS,) the first piece that may hold a thrust which is that share of the largest one."""
        # What a voltage between two makes is, as a share, between the shares of both.
        largest = self.f[:, -1:]
        share = np.divide(self.f, largest, out=np.ones_like(self.f), where=largest > 0)
        least = (np.arange(BUCKETS) - 0.01) / (BUCKETS - 0.5)  # rounding may take a thrust a bucket on
        passed: IndexArray = (share[:, 1:, None] < least).sum(axis=1).min(axis=0)
        return np.minimum(passed, len(self.steps) - 2)


@dataclass(frozen=True, eq=False)
class Tables:
    """What the ESCs of a vehicle do, all that are alike once.

    Attributes
    ----------
    volts : (m,) voltages of the rows [V]; one where all curves have one
    measured : first and last voltage at which all curves were measured, infinite where none says [V]
    sides : ahead and astern of each curve
    jumps : of each curve whether a thrust in the dead band may go to the smallest one
    which : of each thruster its curve
    """

    volts: FloatArray
    measured: tuple[float, float]
    sides: list[CurveSide]
    jumps: list[bool]
    which: list[int]


def tables(escs: Sequence[Esc]) -> Tables:
    """The tables of n ESCs."""
    several = [esc.volts for esc in escs if len(esc.volts) > 1]
    volts = np.unique(np.concatenate(several)) if several else np.zeros(1)
    kinds: dict[object, tuple[int, tuple[CurveSide, CurveSide], bool]] = {}
    which = []
    for esc in escs:
        pair = _sides(esc, volts)
        key = (esc.jump, *(part.tobytes() for side in pair for part in (side.steps, side.f)))
        which.append(kinds.setdefault(key, (len(kinds), pair, esc.jump))[0])
    said = [esc.volts for esc in escs if not np.isnan(esc.volts[0])]
    measured = max((v[0] for v in said), default=-np.inf), min((v[-1] for v in said), default=np.inf)
    found = kinds.values()
    return Tables(
        volts, measured, [side for _, pair, _ in found for side in pair], [j for *_, j in found], which
    )


def _sides(esc: Esc, volts: FloatArray) -> tuple[CurveSide, CurveSide]:
    """An ESC's curve ahead and astern. Between whole steps no command can be sent, and none is a knot."""
    first, last = esc.ends
    along = (esc.command - esc.neutral) / esc.step
    whole = np.concatenate([np.floor(along), np.ceil(along), [first, 0, last]])
    steps = np.unique(np.clip(whole, first, last)).astype(np.intp)
    f = esc.made_at(steps, volts)
    ahead, astern = steps >= 0, steps <= 0
    return _side(steps[ahead], f[:, ahead]), _side(-steps[astern][::-1], -f[:, astern][:, ::-1])


def _side(steps: IndexArray, f: FloatArray) -> CurveSide:
    idle = int((f <= 0).all(axis=0).sum()) - 1  # the last that makes nothing at any voltage
    steps, f = steps[idle:], f[:, idle:]
    if len(steps) == 1:  # no thrust on this side: a piece that no call comes to
        steps, f = np.append(steps, steps + 1), np.repeat(f, 2, axis=1)
    return CurveSide(steps, f)
