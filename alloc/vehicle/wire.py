"""Commands of ESCs for thrusts, and thrusts of commands, for one call or many."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray, IndexArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.esc import Esc, Sent
from alloc.vehicle.limits import Interval

AT_ONCE = 2048
"""Rows that are inverted together, so that a long log takes a few megabytes."""


def commands(
    name: str, escs: Sequence[Esc], f: ArrayLike, volts: ArrayLike | None, f_min: ArrayLike, f_max: ArrayLike
) -> Sent:
    """As ``Vehicle.commands``, with the limits given."""
    wishes, at, single = _rows(name, escs, f, volts, "f")
    low, high = (np.broadcast_to(np.asarray(side, np.float64), wishes.shape) for side in (f_min, f_max))
    sent = _commands(escs, wishes, at, low, high)
    return Sent(*(part[0] for part in sent)) if single else sent


def thrusts(name: str, escs: Sequence[Esc], sent: ArrayLike, volts: ArrayLike | None) -> FloatArray:
    """As ``Vehicle.thrusts``."""
    rows, at, single = _rows(name, escs, sent, volts, "commands")
    made = _thrusts(escs, rows, at)
    return made[0] if single else made


def limits(
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
