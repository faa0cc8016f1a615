"""What one call or many say about ESCs, as rows: what is sent for thrusts, and what commands make."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle import esc
from alloc.vehicle.esc import Esc, Sent


def commands(
    name: str, escs: Sequence[Esc], f: ArrayLike, volts: ArrayLike | None, f_min: ArrayLike, f_max: ArrayLike
) -> Sent:
    """As ``Vehicle.commands``, with the limits given."""
    wishes, at, single = _rows(name, escs, f, volts, "f")
    low, high = (np.broadcast_to(np.asarray(side, np.float64), wishes.shape) for side in (f_min, f_max))
    sent = esc.commands(escs, wishes, at, low, high)
    return Sent(*(part[0] for part in sent)) if single else sent


def thrusts(name: str, escs: Sequence[Esc], sent: ArrayLike, volts: ArrayLike | None) -> FloatArray:
    """As ``Vehicle.thrusts``."""
    rows, at, single = _rows(name, escs, sent, volts, "commands")
    made = esc.thrusts(escs, rows, at)
    return made[0] if single else made


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
