"""Accelerations and velocities beside the outputs in a log, for readiness."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import BoolArray, FloatArray
from alloc.errors import DemandError
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF
from bench.inputs.demand_csv import read_demands
from bench.inputs.log_files import reader
from bench.inputs.outputs import Outputs
from bench.inputs.table import TABLES, read_table

FORM = "m/s^2, rad/s^2, m/s, rad/s, in the vehicle's frame, without gravity"
GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2]."""
GAP = 10.0
"""Median steps of a sensor over which nothing is interpolated [-]."""

Series = tuple[FloatArray, FloatArray]
"""Times (S,) [s], by the log's clock, and values (S, m)."""


class Motion(NamedTuple):
    """Motion of a vehicle at rows of its outputs, in its own frame.

    Attributes
    ----------
    rows : (N,) True for the M rows of the outputs at which the motion is known
    a : (M, k) rates of change of v [m/s^2, rad/s^2]
    v : (M, k) velocities [m/s, rad/s]
    source : which parts of the log these are of, in a line; empty for a table
    """

    rows: BoolArray
    a: FloatArray
    v: FloatArray
    source: str = ""


class Sensors(NamedTuple):
    """Estimates of an autopilot, by the log's clock: body axes ahead, to starboard, down; earth's N, E, D.

    Attributes
    ----------
    force : specific force in body axes, (0, 0, -g) at rest [m/s^2]
    rates : angular velocity in body axes [rad/s]
    attitude : quaternion x, y, z, w that turns body axes into the earth's [-]
    velocity : along the earth's axes [m/s]
    source : which messages these are
    """

    force: Series
    rates: Series
    attitude: Series
    velocity: Series
    source: str


def read_motion(
    path: Path, outputs: Outputs, vehicle: Vehicle, columns: Mapping[str, str] | None = None
) -> Motion:
    """Motion at the rows of outputs of the same log.

    Of a table: columns ``a_surge`` … and ``v_surge`` …, one a DOF. Of an autopilot's log: its inertial
    sensors, and its estimates of attitude and velocity. Raises DemandError for a log that lacks some.
    """
    if path.is_dir() or path.suffix.lower() not in TABLES:
        sensors: Sensors = reader(path, "read_sensors", "log of outputs").read_sensors(path)
        assert outputs.t is not None
        return estimate_motion(path, sensors, outputs.start + outputs.t, vehicle)
    names = [f"{letter}_{axis}" for letter in "av" for axis in vehicle.dof]
    needed = f"--accelerations needs {', '.join(names)} [{FORM}]"
    header = read_table(path).header
    missing = [name for name in names if name not in header]
    if missing:
        raise DemandError(f"{path}: no column {missing[0]!r}; {needed}")
    if outputs.t is None:
        raise DemandError(f"{path}: no column 't'; --accelerations needs times [s]")
    log = read_demands(path, vehicle.dof, columns, commands=names)
    assert log.u is not None
    if len(log.u) != len(outputs.u) or not np.isfinite(log.u).all():
        raise DemandError(f"{path}: some rows have commands and no motion, or no number; cut them out")
    return Motion(np.ones(len(log.u), dtype=bool), log.u[:, : vehicle.k], log.u[:, vehicle.k :])


def estimate_motion(path: Path, sensors: Sensors, t: FloatArray, vehicle: Vehicle) -> Motion:
    """Motion while outputs of times t (N,) [s] last: means over one step from each on.

    The rate of change of the velocity u along body axes is specific force + gravity - w x u.
    """
    from scipy.spatial.transform import Rotation, Slerp

    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    series = (sensors.force, sensors.rates, sensors.attitude, sensors.velocity)
    middles = t + step / 2
    rows = np.logical_and.reduce([_is_covered(times, middles, step) for times, _ in series]) & (step > 0)
    if not rows.any():
        raise DemandError(f"{path}: {sensors.source} are of other times than the outputs; log both at once")
    at = middles[rows]
    rising = np.append(True, np.diff(sensors.attitude[0]) > 0)
    attitude = Slerp(sensors.attitude[0][rising], Rotation.from_quat(sensors.attitude[1][rising]))
    into_body = attitude(at).inv()
    u, w = into_body.apply(_mean(sensors.velocity, at, step)), _mean(sensors.rates, at, step)
    pull = into_body.apply((0.0, 0.0, GRAVITY))
    a = _mean(sensors.force, at, step) + pull - np.cross(w, u)
    turn = (_between(sensors.rates, at + step / 2) - _between(sensors.rates, at - step / 2)) / step
    which = [DOF.index(axis) for axis in vehicle.dof]
    A, V = (np.hstack(parts)[:, which] for parts in ((a, turn), (u, w)))
    if vehicle.frame == "flu":
        A, V = (turned(each.T, vehicle.dof).T for each in (A, V))
    return Motion(rows, A, V, f"{path.name}: motion by {sensors.source}")


def _is_covered(times: FloatArray, at: FloatArray, step: float) -> BoolArray:
    """True for each middle (N,) of a step that a series of times (S,) holds without a gap."""
    steps = np.diff(times)
    longest = max(step, GAP * float(np.median(steps))) if len(steps) else 0.0
    behind = np.searchsorted(times, at - step / 2, side="right")
    inside = (behind > 0) & (at + step / 2 <= times[-1])
    covered: BoolArray = inside & (np.append(steps, np.inf)[np.maximum(behind, 1) - 1] <= longest)
    return covered


def _between(series: Series, at: FloatArray) -> FloatArray:
    """Values (N, m) at times (N,), on straight lines between those of a series."""
    times, values = series
    return np.column_stack([np.interp(at, times, column) for column in values.T])


def _mean(series: Series, at: FloatArray, step: float) -> FloatArray:
    """Means (N, m) of a series over a step around each time (N,)."""
    times, values = series
    pieces = np.diff(times)[:, None] * (values[1:] + values[:-1]) / 2
    whole = times, np.vstack([np.zeros(values.shape[1]), np.cumsum(pieces, axis=0)])
    return (_between(whole, at + step / 2) - _between(whole, at - step / 2)) / step
