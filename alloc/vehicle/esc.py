"""From thrusts to the commands of ESCs, and back: a measured curve, a dead band, and steps of the wire."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alloc.allocation import BoolArray, FloatArray, IndexArray, StatusArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.current import Current, Draw, checked_cap, make_draw
from alloc.vehicle.limits import Interval

ROUNDING = 1e-6
"""Share of a step by which an end of the range may miss a whole step because of rounding [-]."""
SPARE = 1e-14
"""Distance by which rounding may put a thrust beyond a limit, relative to the largest of the curve [-].
Limits at a voltage are interpolated between limits, thrusts between curves: the same number but for a few
last bits of 2e-16 each, which must not cost a step."""


class Made(IntEnum):
    """Thrusts that one thruster makes of those that were asked."""

    MADE = 0
    """It is made, to half a step of the command."""
    IN_DEAD_BAND = 1
    """It is less than the smallest thrust: neutral is sent, or with ``jump`` the nearer of the two."""
    AT_END = 2
    """It lies beyond the range of the commands, or beyond the limits of the call: the end is sent."""
    OUTSIDE_TABLE = 3
    """The curve was not measured at such a voltage: that of the nearest is taken, for NaN of the highest."""
    NO_NUMBER = 4
    """It is NaN or infinite: neutral is sent."""


class Sent(NamedTuple):
    """Commands to the ESCs.

    Attributes
    ----------
    u : (n,) or (N, n) commands, integers where neutral, range and step are
    f : (n,) or (N, n) what they make by the curve [N]
    status : (n,) or (N, n) a ``Made`` for each thruster
    """

    u: NDArray[Any]
    f: FloatArray
    status: StatusArray


@dataclass(frozen=True, eq=False)
class Esc:
    """An ESC and the thruster behind it.

    Between two commands of the curve, and between two voltages, thrust is linear.

    Attributes
    ----------
    neutral, low, high, step : command of no thrust, ends of the range, and what the wire resolves
    jump : whether a thrust in the dead band goes to the nearer of neutral and the smallest thrust
    reversed : whether the ESC runs the other way: the command is mirrored about neutral
    volts : (m,) voltages of the curve, rising [V]; (1,) NaN where none is known
    command : (K,) rising commands of the curve as if not reversed, neutral among them
    curve : (m, K) never falling, 0 at neutral [N]
    nominal : voltage where a call says none [V]; NaN where nothing says
    current : what the thruster draws; None where nothing says
    """

    neutral: float
    low: float
    high: float
    step: float
    jump: bool
    reversed: bool
    volts: FloatArray
    command: FloatArray
    curve: FloatArray
    nominal: float
    current: Current | None = None

    @property
    def whole(self) -> bool:
        """True if commands are integers."""
        return all(float(x).is_integer() for x in (self.neutral, self.low, self.high, self.step))

    @property
    def needs_volts(self) -> bool:
        """True if a call must say the voltage: the curve has several, and the file names none."""
        return bool(np.isnan(self.nominal)) and len(self.volts) > 1

    @property
    def largest_step(self) -> float:
        """The most that one step changes the thrust by, at any voltage [N]."""
        slopes = np.diff(self.curve, axis=1) / np.diff(self.command)
        return float(slopes.max() * self.step)

    @property
    def ends(self) -> tuple[int, int]:
        """The first and the last command in steps from neutral, as if not reversed."""
        first, last = (self.command[[0, -1]] - self.neutral) / self.step
        return int(np.ceil(first - ROUNDING)), int(np.floor(last + ROUNDING))

    def outside(self, volts: FloatArray) -> BoolArray:
        """Mask of voltages (N,) [V] at which the curve was not measured."""
        if np.isnan(self.volts[0]):
            return np.zeros(volts.shape, dtype=bool)
        result: BoolArray = ~((volts >= self.volts[0]) & (volts <= self.volts[-1]))
        return result

    def at(self, volts: FloatArray) -> FloatArray:
        """(N, K) thrust of each command of the curve at voltages (N,) [N]."""
        if len(self.volts) == 1:
            return np.broadcast_to(self.curve[0], (len(volts), len(self.command)))
        held = np.where(volts <= self.volts[-1], np.maximum(volts, self.volts[0]), self.volts[-1])
        i = np.clip(np.searchsorted(self.volts, held, side="right") - 1, 0, len(self.volts) - 2)
        share = (held - self.volts[i]) / (self.volts[i + 1] - self.volts[i])
        # Two products, because their sum rises where both curves do, and is either one at its own voltage.
        blended: FloatArray = (1.0 - share)[:, None] * self.curve[i] + share[:, None] * self.curve[i + 1]
        return blended

    def span(self, volts: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The least and the largest thrust (N,) that any command makes at voltages (N,) [N]."""
        curve = self.at(volts)
        least, most = (self._made(np.full((len(volts), 1), j), curve)[:, 0] for j in self.ends)
        return least, most

    def made(self, u: FloatArray, volts: FloatArray) -> FloatArray:
        """Thrusts of commands u (N, m) at voltages (N,) [N].

        Commands beyond the range make what its end makes, NaN makes NaN.
        """
        c = np.clip(u, self.low, self.high)
        along = (self.neutral - c if self.reversed else c - self.neutral) / self.step
        return self._made(along, self.at(volts))

    def made_at(self, steps: IndexArray, volts: FloatArray) -> FloatArray:
        """(N, K) thrusts so many steps (K,) from neutral, as if not reversed, at voltages (N,) [N]."""
        return self._made(np.broadcast_to(steps, (len(volts), len(steps))), self.at(volts))

    def sent(
        self, f: FloatArray, volts: FloatArray, f_min: FloatArray, f_max: FloatArray
    ) -> tuple[FloatArray, FloatArray, StatusArray]:
        """Commands, what they make [N] and a status for wishes f (N, m) [N], limits (N, m) [N] each.

        The wish is cut at the limits and at the ends of the curve, and the step is taken whose thrust is
        nearest; where that lies beyond a limit by more than rounding, the next one within.
        """
        curve, (first, last) = self.at(volts), self.ends
        known = np.isfinite(f)
        least, most = self.span(volts)
        spare = SPARE * np.abs(self.curve).max()
        low, high = (np.clip(side, least[:, None], most[:, None]) for side in (f_min, f_max))
        asked = np.where(known, f, 0.0)
        wish = np.clip(asked, low, high)
        j = self._nearest(wish, curve)
        # The dead band ends at the outermost commands that make nothing; the smallest thrusts lie a step on.
        zero_from = self.command[(curve < 0).sum(axis=1)]
        zero_to = self.command[(curve <= 0).sum(axis=1) - 1]
        ahead = np.floor((zero_to - self.neutral) / self.step + ROUNDING)[:, None] + 1
        astern = np.ceil((zero_from - self.neutral) / self.step - ROUNDING)[:, None] - 1
        smallest = np.clip(np.where(wish < 0, astern, ahead), first, last)
        at_least = self._made(smallest, curve)
        inside = (np.abs(wish) < np.abs(at_least)) & (wish != 0)
        inside |= (j > astern) & (j < ahead) & (wish != 0)
        may_stop = (low <= 0) & (high >= 0)
        jumps = (np.abs(wish) >= 0.5 * np.abs(at_least)) if self.jump else np.zeros_like(inside)
        j = np.where(inside, np.where(jumps | ~may_stop, smallest, 0.0), j)
        j = np.where((wish == 0) & may_stop, 0.0, j)
        # Where no step lies within the limits, that of the smaller thrust is sent.
        outward = np.where(wish < 0, -1.0, 1.0)
        makes = outward * self._made(j, curve)
        j = np.where(makes < np.where(wish < 0, -high, low) - spare, j + outward, j)
        makes = outward * self._made(j, curve)
        j = np.clip(np.where(makes > np.where(wish < 0, -low, high) + spare, j - outward, j), first, last)
        j = np.where((j > astern) & (j < ahead), 0.0, j)
        status = np.full(f.shape, int(Made.MADE), dtype=np.int8)
        status[inside] = Made.IN_DEAD_BAND
        status[(asked < low - spare) | (asked > high + spare)] = Made.AT_END
        status[self.outside(volts)] = Made.OUTSIDE_TABLE
        status[~known] = Made.NO_NUMBER
        j = np.where(known, j, 0.0)
        makes = self._made(j, curve)
        held = np.clip(makes, low, high)
        makes = np.where(np.abs(makes - held) <= spare, held, makes)
        return self.neutral + (-j if self.reversed else j) * self.step, makes, status

    def _nearest(self, wish: FloatArray, curve: FloatArray) -> FloatArray:
        """The step (N, m) from neutral whose thrust is nearest to the wish (N, m).

        Of two that are as near the one that makes more is taken; of two that make the same the one nearer to
        neutral, so a curve that ends flat is not driven to its end.
        """
        first, last = self.ends
        along = (self._inverse(wish, curve) - self.neutral) / self.step
        lower = np.clip(np.floor(along), first, max(first, last - 1))
        upper = np.minimum(lower + 1.0, last)
        least, most = self._made(lower, curve), self._made(upper, curve)
        above, below, same = most - wish, wish - least, most == least
        return np.where(np.where(wish < 0, same | (above < below), ~same & (above <= below)), upper, lower)

    def _made(self, along: FloatArray, curve: FloatArray) -> FloatArray:
        """Thrust (N, m) of commands that many steps from neutral (N, m), by the rows' curves (N, K) [N]."""
        c = np.clip(self.neutral + along * self.step, self.command[0], self.command[-1])
        k = np.clip(np.searchsorted(self.command, c, side="right") - 1, 0, len(self.command) - 2)
        share = (c - self.command[k]) / (self.command[k + 1] - self.command[k])
        below, above = np.take_along_axis(curve, k, 1), np.take_along_axis(curve, k + 1, 1)
        thrust: FloatArray = below + share * (above - below)
        return thrust

    def _inverse(self, f: FloatArray, curve: FloatArray) -> FloatArray:
        """The command (N, m) nearest to neutral that makes f (N, m), within the ends of curve (N, K)."""
        rows = curve[:, None, :]
        ahead = (rows < f[..., None]).sum(axis=2)  # the first command that makes f or more
        astern = (rows <= f[..., None]).sum(axis=2)  # the first that makes more than f
        k = np.clip(np.where(f < 0, astern, ahead), 1, len(self.command) - 1)
        below, above = np.take_along_axis(curve, k - 1, 1), np.take_along_axis(curve, k, 1)
        rise = above - below
        share = np.clip((f - below) / np.where(rise > 0, rise, 1.0), 0.0, 1.0)
        command: FloatArray = self.command[k - 1] + share * (self.command[k] - self.command[k - 1])
        return command


AT_ONCE = 2048
"""Rows that are inverted together, so that a long log takes a few megabytes."""


def esc_commands(
    name: str,
    escs: Sequence[Esc],
    f: ArrayLike,
    volts: ArrayLike | None,
    f_min: ArrayLike,
    f_max: ArrayLike,
    cap: ArrayLike | None = None,
) -> Sent:
    """As ``Vehicle.commands``, with the limits given."""
    wishes, at, single = _rows(name, escs, f, volts, "f")
    low, high = (np.broadcast_to(np.asarray(side, np.float64), wishes.shape) for side in (f_min, f_max))
    sent = _commands(escs, wishes, at, low, high)
    if cap is not None:
        most = np.broadcast_to([checked_cap(one) for one in np.atleast_1d(cap).tolist()], len(wishes))
        draws = [esc_draw(name, escs, None if np.isneginf(v) else float(v)) for v in at]
        over = [i for i, draw in enumerate(draws) if draw.amps(sent.f[i]).sum() > most[i]]
        # Limits at the wish itself leave the next command towards neutral.
        known = np.where(np.isfinite(wishes), wishes, 0.0)
        inner = np.maximum(low, np.minimum(known, 0.0)), np.minimum(high, np.maximum(known, 0.0))
        again = _commands(escs, wishes[over], at[over], inner[0][over], inner[1][over])
        for field in Sent._fields:
            getattr(sent, field)[over] = getattr(again, field)
    return Sent(*(part[0] for part in sent)) if single else sent


def esc_thrusts(name: str, escs: Sequence[Esc], sent: ArrayLike, volts: ArrayLike | None) -> FloatArray:
    """As ``Vehicle.thrusts``."""
    rows, at, single = _rows(name, escs, sent, volts, "commands")
    made = _thrusts(escs, rows, at)
    return made[0] if single else made


def esc_limits(
    name: str, escs: Sequence[Esc], volts: ArrayLike | None, f_min: ArrayLike, f_max: ArrayLike
) -> Interval:
    """As ``Vehicle.esc_limits``, with the limits given."""
    sides = np.stack(np.broadcast_arrays(np.asarray(f_min, np.float64), np.asarray(f_max, np.float64)))
    if volts is not None and sides.ndim == 2 and np.ndim(volts) == 1:
        sides = np.repeat(sides[:, None], np.size(volts), axis=1)
    low, at, single = _rows(name, escs, sides[0], volts, "f_min")
    high, *_ = _rows(name, escs, sides[1], volts, "f_max")
    crossed = ~(low <= high)
    kept = low[crossed], high[crossed]
    for esc, columns in _alike(escs):
        ends = [end[:, None] for end in esc.span(_nominal(esc, at))]
        low[:, columns], high[:, columns] = (np.clip(side[:, columns], *ends) for side in (low, high))
    low[crossed], high[crossed] = kept
    return (low[0], high[0]) if single else (low, high)


def esc_draw(name: str, escs: Sequence[Esc], volts: float | None) -> Draw:
    """As ``Vehicle.draw``."""
    currents = [esc.current for esc in escs if esc.current is not None]
    if not currents or len(currents) < len(escs):
        raise VehicleError(f"{name}: has no currents; add 'current' to 'esc' in its file", "esc")
    if volts is not None and not 0.0 < volts < np.inf:
        raise DemandError(f"volts: got {volts}, expected a number above 0 [V]")
    at = np.array([-np.inf if volts is None else volts])
    known = [0.0 if np.isnan(volts := _nominal(esc, at)[0]) else float(volts) for esc in escs]
    return make_draw(tuple(currents), tuple(known))


def _rows(
    name: str, escs: Sequence[Esc], values: ArrayLike, volts: ArrayLike | None, key: str
) -> tuple[FloatArray, FloatArray, bool]:
    """Values as (N, n), voltages as (N,), -inf where none is given, and whether there is one row."""
    if not escs:
        raise VehicleError(f"{name}: has no ESCs; add 'esc' to its file", "esc")
    n = len(escs)
    try:
        given = np.asarray(values, dtype=np.float64)
        at = np.asarray(-np.inf if volts is None else volts, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise DemandError(f"{key} or volts is not an array of numbers ({error})") from None
    if given.ndim not in (1, 2) or given.shape[-1] != n:
        raise DemandError(f"{key} has shape {given.shape}; give ({n},) or (N, {n})")
    rows = np.atleast_2d(given)
    if at.shape not in ((), (len(rows),)):
        raise DemandError(f"volts has shape {at.shape}; give one number, or ({len(rows)},) [V]")
    return rows, np.broadcast_to(at, (len(rows),)), given.ndim == 1


def _commands(
    escs: Sequence[Esc], f: FloatArray, volts: FloatArray, f_min: FloatArray, f_max: FloatArray
) -> Sent:
    """Commands of n ESCs for f (N, n) [N] within limits (N, n) [N], each row at its voltage (N,) [V].

    -inf stands for a voltage left out; raises DemandError where it is and an ESC's curve has several.
    """
    u, makes = np.empty(f.shape), np.empty(f.shape)
    status = np.empty(f.shape, dtype=np.int8)
    for esc, columns in _alike(escs):
        at = _nominal(esc, volts)
        for start in range(0, len(f), AT_ONCE):
            rows = slice(start, start + AT_ONCE)
            cell = np.ix_(np.arange(len(f))[rows], columns)
            u[cell], makes[cell], status[cell] = esc.sent(f[cell], at[rows], f_min[cell], f_max[cell])
    whole = all(esc.whole for esc in escs)
    return Sent(np.rint(u).astype(np.int64) if whole else u, makes, status)


def _thrusts(escs: Sequence[Esc], u: FloatArray, volts: FloatArray) -> FloatArray:
    """Thrusts of commands u (N, n) [N], each row at its voltage (N,) [V]; raises as ``commands``."""
    f = np.empty(u.shape)
    for esc, columns in _alike(escs):
        f[:, columns] = esc.made(u[:, columns], _nominal(esc, volts))
    return f


def _alike(escs: Sequence[Esc]) -> list[tuple[Esc, IndexArray]]:
    """Each ESC with the indices of the thrusters that share it."""
    return [
        (esc, np.array([i for i, other in enumerate(escs) if other is esc])) for esc in dict.fromkeys(escs)
    ]


def _nominal(esc: Esc, volts: FloatArray) -> FloatArray:
    """The voltages (N,) [V], the nominal one where the call gives none, which is an array of -inf."""
    if len(volts) and np.isneginf(volts[0]):
        if esc.needs_volts:
            raise DemandError(
                f"the ESC's curve has {esc.volts[0]:g} to {esc.volts[-1]:g} V; give volts,"
                " or 'volts' in 'esc'"
            )
        return np.full(volts.shape, esc.volts[0] if np.isnan(esc.nominal) else esc.nominal)
    return volts
