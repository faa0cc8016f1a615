"""Logs of what went to the ESCs. Each module here reads one kind of log.

A module has ``SUFFIXES`` of the files it reads and ``read(path, vehicle) -> Outputs``.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from bench.inputs.by_suffix import reader


class Outputs(NamedTuple):
    """What a vehicle recorded of its outputs.

    Attributes
    ----------
    t : (N,) times since the first one [s], never decreasing; None where the log has none
    u : (N, n) commands, in the order of the vehicle's thrusters
    volts : (N,) of the battery [V]; None where the log has none
    taus : (N, k) wrenches demanded at the same times, in the vehicle's frame [N, N m]; in shares of what the
        vehicle can do where ``shares`` says so; NaN on axes, or (N, k) None, of which the log says nothing
    shares : whether ``taus`` are shares, 1 for all that the vehicle can do on an axis
    said : how the log was understood, in a line
    """

    t: FloatArray | None
    u: FloatArray
    volts: FloatArray | None = None
    taus: FloatArray | None = None
    shares: bool = False
    said: str = ""


def read_outputs(path: Path, vehicle: Vehicle) -> Outputs:
    """What a log says of a vehicle's outputs; a pulse of 0, which is none, counts as neutral.

    Raises FileError, DemandError or NotInstalled.
    """
    outputs: Outputs = reader(__name__, path, "log of outputs").read(path, vehicle)
    if not len(outputs.u):
        raise DemandError(f"{path}: holds no outputs; log them")
    bad = np.flatnonzero(~np.isfinite(outputs.u).all(axis=1))
    if bad.size:
        raise DemandError(f"{path}: output {bad[0]} (counted from 0) is no number; cut it out")
    # An ESC whose range lies beyond 0 gets no pulse then.
    silent = [not esc.low <= 0 <= esc.high for esc in vehicle.esc]
    neutral = [esc.neutral for esc in vehicle.esc]
    return outputs._replace(u=np.where((outputs.u == 0) & silent, neutral, outputs.u))


def held(times: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Values (M, …) of rising times (M,) as they held at other times (N,): the last, or the first of all."""
    return values[np.maximum(np.searchsorted(times, at, side="right") - 1, 0)]
