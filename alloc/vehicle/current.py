"""Current of thrusters by their thrust, convex on each side of rest, and a cap on what all draw together."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import DemandError, SolverError

LAW_PIECES = 40
"""Straight pieces a side that stand in for a power law where a linear program is asked. On a BlueROV2-Heavy
they take up to 4e-4 of the share that the law itself allows."""


Tangent = Callable[[float], tuple[float, float]]
"""Current at one thrust [A], and its slope there [A/N], to the right where two pieces meet."""


class Pieces(NamedTuple):
    """Current that is linear between thrusts, and convex; the outermost pieces have no end.

    Attributes
    ----------
    f : (p,) rising [N]
    amps : (p,) the current at each [A]
    slopes : (p - 1,) of the pieces between them, rising [A/N]
    """

    f: FloatArray
    amps: FloatArray
    slopes: FloatArray

    def draws(self, f: FloatArray) -> FloatArray:
        """Current of each thrust [A]."""
        piece = self.f[1:-1].searchsorted(f, side="right")
        current: FloatArray = self.amps[piece] + self.slopes[piece] * (f - self.f[piece])
        return current

    def tangent(self) -> Tangent:
        """The current as a function of one thrust."""
        ends, f, amps, slopes = (x.tolist() for x in (self.f[1:-1], self.f, self.amps, self.slopes))

        def at(x: float) -> tuple[float, float]:
            i = bisect_right(ends, x)
            return amps[i] + slopes[i] * (x - f[i]), slopes[i]

        return at

    def pieces(self, f_min: float, f_max: float) -> "Pieces":
        """The same current."""
        return self


class PowerLaw(NamedTuple):
    """Current a |f|^p of thrust f, alike at every voltage.

    Attributes
    ----------
    ahead, astern : a for f above and below 0 [A/N^p]
    power : p, at least 1 [-]
    """

    ahead: float
    astern: float
    power: float

    def draws(self, f: FloatArray) -> FloatArray:
        """Current of each thrust [A]."""
        current: FloatArray = np.where(f < 0, self.astern, self.ahead) * np.abs(f) ** self.power
        return current

    def tangent(self) -> Tangent:
        """The current as a function of one thrust."""
        ahead, astern, power = self

        def at(x: float) -> tuple[float, float]:
            rise = (ahead if x >= 0.0 else -astern) * abs(x) ** (power - 1.0)
            return rise * x, power * rise

        return at

    def pieces(self, f_min: float, f_max: float) -> Pieces:
        """``LAW_PIECES`` chords a side within the limits [N]; they lie on the law and above it."""
        # Squared steps: the law bends most next to rest.
        steps = np.linspace(0.0, 1.0, LAW_PIECES + 1) ** 2
        f = np.concatenate([min(f_min, -1.0) * steps[:0:-1], max(f_max, 1.0) * steps])
        return _through(f, self.draws(f))

    def at(self, volts: float) -> "PowerLaw":
        """The same law."""
        return self


@dataclass(frozen=True, eq=False)
class CurrentTable:
    """Measured current, at each thrust linear between the voltages.

    Attributes
    ----------
    volts : (m,) rising [V]; (1,) NaN where none is known
    measured : (p, 2) thrust and current at each of them, thrusts rising, 0 among them [N, A]
    """

    volts: FloatArray
    measured: tuple[FloatArray, ...]

    @cached_property
    def convex(self) -> tuple[Pieces, ...]:
        """Convex currents, nowhere below the measured points."""
        return tuple(_through(f, _raised(f, amps)) for f, amps in (points.T for points in self.measured))

    def at(self, volts: float) -> Pieces:
        """The current at a voltage [V], beyond those of the table that of the nearest."""
        if len(self.volts) == 1 or volts <= self.volts[0]:
            return self.convex[0]
        if volts >= self.volts[-1]:
            return self.convex[-1]
        i = int(np.searchsorted(self.volts, volts, side="right")) - 1
        if (share := (volts - self.volts[i]) / (self.volts[i + 1] - self.volts[i])) == 0.0:
            return self.convex[i]
        below, above = self.convex[i], self.convex[i + 1]
        f = np.union1d(below.f, above.f)
        # The sum of convex functions is convex.
        return _through(f, (1.0 - share) * below.draws(f) + share * above.draws(f))


Current = PowerLaw | CurrentTable


def _through(f: FloatArray, amps: FloatArray) -> Pieces:
    """The pieces through points f (p,) [N] and amps (p,) [A]; a side without any is as the other."""
    if f[0] == 0.0:
        f, amps = np.append(-f[:0:-1], f), np.append(amps[:0:-1], amps)
    elif f[-1] == 0.0:
        f, amps = np.append(f, -f[-2::-1]), np.append(amps, amps[-2::-1])
    return Pieces(f, amps, np.diff(amps) / np.diff(f))


def _raised(f: FloatArray, amps: FloatArray) -> FloatArray:
    """Amps (p,) raised to the convex curve of least sum that lies nowhere below them; at rest they stay.

    Each side is a linear program of its own.
    """
    rest = int(np.flatnonzero(f == 0.0)[0])
    astern = _raised_side(-f[rest::-1], amps[rest::-1])[::-1]
    ahead = _raised_side(f[rest:], amps[rest:])
    return np.concatenate([astern[:-1], ahead])


def _raised_side(f: FloatArray, amps: FloatArray) -> FloatArray:
    """``_raised`` of points from rest outwards."""
    slopes = np.diff(amps) / np.diff(f)
    if (np.diff(slopes, prepend=0.0) >= 0.0).all():
        return amps
    from scipy.optimize import linprog

    p, steps = len(f), np.diff(f)
    rises = np.zeros((p - 1, p))
    rises[range(p - 1), range(p - 1)], rises[range(p - 1), range(1, p)] = -1.0 / steps, 1.0 / steps
    falls = -np.diff(rises, axis=0, prepend=np.zeros((1, p)))
    bounds = [(x, x if i == 0 else None) for i, x in enumerate(amps)]
    found = linprog(np.ones(p), A_ub=falls, b_ub=np.zeros(p - 1), bounds=bounds, method="highs")
    if found.x is None:
        raise SolverError(f"HiGHS gave up on the convex current: {found.message}")
    # HiGHS meets rows to 1e-7: what it leaves of a bend is taken from the slopes.
    raised = np.maximum(found.x, amps)
    bent = np.maximum.accumulate(np.diff(raised) / steps)
    return np.concatenate([raised[:1], raised[0] + np.cumsum(bent * steps)])


class Draw(NamedTuple):
    """Current of n thrusters at one voltage.

    Attributes
    ----------
    groups : the curves, each with the thrusters that have it
    tangents : of each thruster, for single thrusts: a call's few are quicker so than as arrays
    """

    groups: tuple[tuple[Pieces | PowerLaw, IndexArray], ...]
    tangents: tuple[Tangent, ...]

    def amps(self, f: FloatArray) -> FloatArray:
        """Current (…, n) of each thruster at thrusts (…, n) [A]."""
        if len(self.groups) == 1:
            return self.groups[0][0].draws(f)
        current = np.empty(f.shape)
        for curve, columns in self.groups:
            current[..., columns] = curve.draws(f[..., columns])
        return current

    def largest(self, f_min: FloatArray, f_max: FloatArray) -> float:
        """Current of all together, each at the limit (n,) that draws more [A]."""
        return float(np.maximum(self.amps(f_min), self.amps(f_max)).sum())

    def pieces(self, low: FloatArray, high: FloatArray) -> tuple[IndexArray, FloatArray, FloatArray]:
        """Thruster, length [N] and slope [A/N] of each straight piece within limits (n,), in order [N]."""
        thruster: list[int] = []
        lengths, slopes = [], []
        for curve, columns in self.groups:
            for i in columns.tolist():
                pieces = curve.pieces(low[i], high[i])
                inside = pieces.f[(pieces.f > low[i]) & (pieces.f < high[i])]
                ends = np.unique(np.concatenate([[low[i]], inside, [high[i]]]))
                lengths.append(np.diff(ends))
                slopes.append(np.diff(pieces.draws(ends)) / lengths[-1])
                thruster += [i] * len(lengths[-1])
        return np.array(thruster, dtype=np.intp), np.concatenate(lengths), np.concatenate(slopes)

    def total(self, begin: Sequence[float], step: Sequence[float], t: float) -> tuple[float, float]:
        """Current of all at thrusts begin + t step (n,) [A], and its slope in t."""
        current = slope = 0.0
        for tangent, start, way in zip(self.tangents, begin, step, strict=True):
            amps, rise = tangent(start + t * way)
            current += amps
            slope += rise * way
        return current, slope


@lru_cache(maxsize=256)
def make_draw(currents: Sequence[Current], volts: Sequence[float]) -> Draw:
    """The currents of n thrusters, each at its voltage [V]."""
    alike: dict[tuple[int, float], list[int]] = {}
    for i, (current, at) in enumerate(zip(currents, volts, strict=True)):
        alike.setdefault((id(current), at), []).append(i)
    groups = [(currents[c[0]].at(volts[c[0]]), c) for c in alike.values()]
    tangents = {i: tangent for curve, c in groups for tangent in [curve.tangent()] for i in c}
    return Draw(
        tuple((curve, np.array(c, dtype=np.intp)) for curve, c in groups),
        tuple(tangents[i] for i in range(len(currents))),
    )


class Cap(NamedTuple):
    """Cap of a vehicle's file on what its thrusters draw together.

    Attributes
    ----------
    most : of the supply [A], or [W] with ``of_power``
    reserve : what everything else draws of it, in the same unit
    of_power : whether both are watts
    volts : voltage where a call says none [V]; None where nothing says
    """

    most: float
    reserve: float = 0.0
    of_power: bool = False
    volts: float | None = None

    def amps(self, volts: float | None = None) -> float:
        """Amperes left for the thrusters; raises DemandError for watts without a voltage [V]."""
        left = self.most - self.reserve
        if not self.of_power:
            return left
        at = self.volts if volts is None else volts
        if at is None or not 0.0 < at < inf:
            raise DemandError(f"volts: got {at}, expected a number above 0, since the cap is in watts [V]")
        return left / at


def checked_cap(cap: float) -> float:
    """A cap of a call [A]; raises DemandError unless it is a finite number, 0 or more."""
    try:
        if 0.0 <= float(cap) < inf:
            return float(cap)
    except (TypeError, ValueError, OverflowError):
        pass
    raise DemandError(f"cap: got {cap!r:.60}, expected a finite number of amperes, 0 or more")
