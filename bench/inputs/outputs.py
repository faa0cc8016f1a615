"""Logs of what went to the ESCs, and of the motion beside it: tables, and logs that have ``read_outputs``."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import BoolArray, FloatArray
from alloc.errors import DemandError
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import DOF
from bench.inputs.columns import VOLTS
from bench.inputs.demand_csv import read_demands
from bench.inputs.frames import Stated, turn_to_frame
from bench.inputs.log_files import reader
from bench.inputs.table import TABLES, read_table

UNPOWERED = "; no voltage was measured, that of 'esc' is taken"
FORM = "m/s^2, rad/s^2, m/s, rad/s, in the vehicle's frame, without gravity"
GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2]."""
GAP = 10.0
"""Median steps of a sensor over which nothing is interpolated [-]."""

Series = tuple[FloatArray, FloatArray]
"""Times (S,) [s], by the log's clock, and values (S, m)."""


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


class Outputs(NamedTuple):
    """Recorded outputs of a vehicle.

    Attributes
    ----------
    t : (N,) times since the first one [s], never decreasing; None where the log has none
    u : (N, n) commands, in the order of the vehicle's thrusters
    volts : (N,) of the battery [V]; None where the log has none
    amps : (N,) drawn from the battery [A], NaN where it was not measured; None where the log has none
    start : time of the first output by the log's own clock [s]
    taus : (N, k) wrenches demanded at the same times, in the vehicle's frame once read [N, N m]; in shares of
        what the vehicle can do where ``shares`` says so; NaN on axes, or None, of which the log says nothing
    shares : whether ``taus`` are shares, 1 for what the vehicle can do both ways on an axis
    notes : how the log was understood, in a line
    stated : the frame that the log states of the demands
    doubt : what may be wrong, in a line; empty for nothing
    sensors : of the same log, where they were asked for
    """

    t: FloatArray | None
    u: FloatArray
    volts: FloatArray | None = None
    taus: FloatArray | None = None
    shares: bool = False
    notes: str = ""
    stated: Stated = Stated()
    doubt: str = ""
    amps: FloatArray | None = None
    start: float = 0.0
    sensors: Sensors | None = None


def read_outputs(
    path: Path,
    vehicle: Vehicle,
    columns: Mapping[str, str] | None = None,
    frame: str = "",
    topic: str = "",
    *,
    sensed: bool = False,
) -> Outputs:
    """Outputs in a log; a pulse of 0, which is none, counts as neutral.

    The user may give the ``columns`` of a table, the ``frame`` of the demands, and as ``topic`` which
    instance of a ULog's outputs is which bank. ``sensed`` asks for an autopilot's ``sensors`` too. Raises
    FileError, DemandError or NotInstalled.
    """
    is_table = not path.is_dir() and path.suffix.lower() in TABLES
    module = None if is_table else reader(path, "read_outputs", "log of outputs")
    if columns and module:
        raise DemandError(f"{path}: has no columns; --columns is for tables, leave it out")
    if topic and not getattr(module, "TOPIC", False):
        raise DemandError(f"{path}: has no instances to choose of; --topic is for ULogs, leave it out")
    if module:
        outputs: Outputs = module.read_outputs(path, vehicle, topic, sensed)
    else:
        outputs = _read_table(path, vehicle, columns)
    if not len(outputs.u):
        raise DemandError(f"{path}: holds no outputs; log them")
    bad = np.flatnonzero(~np.isfinite(outputs.u).all(axis=1))
    if bad.size:
        raise DemandError(f"{path}: a command in row {bad[0]} (counted from 0) is no number; cut it out")
    # An ESC whose range lies beyond 0 gets no pulse then.
    silent = [not esc.low <= 0 <= esc.high for esc in vehicle.esc]
    neutral = [esc.neutral for esc in vehicle.esc]
    doubt = "; ".join(filter(None, (outputs.doubt, _beyond(path, outputs.u, vehicle))))
    outputs = outputs._replace(u=np.where((outputs.u == 0) & silent, neutral, outputs.u), doubt=doubt)
    if outputs.taus is not None:
        taus, turning = turn_to_frame(path, outputs.taus, vehicle.dof, outputs.stated, frame, vehicle.frame)
        outputs = outputs._replace(taus=taus, notes=f"{outputs.notes}; {turning}")
    elif frame:
        raise DemandError(f"{path}: has no demands that could be in a frame; leave out --frame {frame}")
    if outputs.volts is not None:
        return _powered(outputs, outputs.volts)
    several = any(len(esc.volts) > 1 for esc in vehicle.esc)
    return outputs._replace(notes=outputs.notes + UNPOWERED) if several else outputs


def _read_table(path: Path, vehicle: Vehicle, columns: Mapping[str, str] | None) -> Outputs:
    """Columns ``u0``, ``u1``, … and, where there are such, times, ``volts`` and demands, named as in any log.

    A row whose cells of demands are all empty, or NaN, has commands and no demand; one without commands is
    left out.
    """
    log = read_demands(path, vehicle.dof, columns, commands=[f"u{i}" for i in range(vehicle.n)])
    assert log.u is not None
    return Outputs(
        log.t,
        log.u,
        log.columns.get(VOLTS),
        log.taus if log.axes else None,
        notes=log.notes,
        shares=log.shares,
        stated=log.stated,
        doubt=log.doubt,
    )


def _beyond(path: Path, u: FloatArray, vehicle: Vehicle) -> str:
    """A doubt about commands beyond the ranges of their ESCs.

    Raises DemandError where most of a thruster's are: these are in another unit, as shares are for pulses.
    """
    low, high = np.array([(esc.low - esc.step, esc.high + esc.step) for esc in vehicle.esc]).T
    outside = (u != 0) & ~((u >= low) & (u <= high))
    if not outside.any():
        return ""
    most = 2 * outside.sum(axis=0) > (u != 0).sum(axis=0)
    row, i = np.argwhere(outside & most if most.any() else outside)[0]
    first = f"u{i} = {u[row, i]:g} in row {row} (counted from 0)"
    esc = vehicle.esc[i]
    if most.any():
        raise DemandError(
            f"{path}: {first} and most others of it lie outside of the ESC's range, {esc.low:g} to"
            f" {esc.high:g}; give commands in its unit, or mend 'esc' in the vehicle's file"
        )
    return (
        f"{path.name}: {outside.sum()} of {u.size} commands lie outside of their ESC's range and are taken"
        f" for its end, first {first}"
    )


def _powered(outputs: Outputs, volts: FloatArray) -> Outputs:
    """The outputs with a voltage that was measured in each row; without any, with none."""
    measured = np.flatnonzero(volts > 0)  # a log has 0 V or NaN where nothing measures the battery
    if len(measured) == len(volts):
        return outputs
    if not measured.size:
        return outputs._replace(volts=None, notes=outputs.notes + UNPOWERED)
    lacking = f"{len(volts) - len(measured)} of {len(volts)} rows"
    rows = np.arange(len(volts), dtype=np.float64)
    return outputs._replace(
        volts=hold_last(measured.astype(np.float64), volts[measured], rows),
        notes=f"{outputs.notes}; no voltage in {lacking}, the one before is held",
    )


def mirror_doubt(path: Path, vehicle: Vehicle, ways: Mapping[int, bool], parameters: str) -> str:
    """A doubt where the log's ``parameters`` mirror other motors' pulses than ``esc.reversed`` does.

    ``ways`` says of each thruster, counted from 0, whether its pulses are mirrored, where the log says it.
    """
    other = [i for i, way in ways.items() if vehicle.esc and vehicle.esc[i].reversed != way]
    if not other:
        return ""
    those = ", ".join(str(i + 1) for i in other)
    return (
        f"{path.name}: its {parameters} and 'reversed' of the vehicle differ on motors {those} (counted from"
        " 1), whose thrusts have the wrong sign unless a propeller makes up for it; `check --probe` says"
        " which way each pushes"
    )


def motor_channels(path: Path, named: Sequence[int | None], parameters: str) -> list[int]:
    """The output, counted from 1, of each of n motors; 1 to n where ``parameters`` name none.

    Raises DemandError where some are named and others are not: any output for those would be a guess.
    """
    missing = [str(motor) for motor, channel in enumerate(named, start=1) if channel is None]
    if len(missing) == len(named):
        return list(range(1, len(named) + 1))
    if missing:
        raise DemandError(
            f"{path}: no {parameters} names motor {', '.join(missing)}; is the log of this vehicle?"
        )
    return [channel for channel in named if channel is not None]


def join_rows(parts: Sequence[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray, str]:
    """Rows of messages side by side at the times of the first, and what is said of rows that are left out.

    Each message has times (M,) and values (M, …). The row nearest in time is taken, and a row is left out
    where that is more than a step away: that message was not logged then.
    """
    times, values = parts[0]
    kept, columns = np.ones(len(times), dtype=bool), [values]
    for others, more in parts[1:]:
        near = np.searchsorted((others[1:] + others[:-1]) / 2, times)
        step = max((np.median(np.diff(each)) for each in (times, others) if len(each) > 1), default=np.inf)
        kept &= np.abs(others[near] - times) <= step
        columns.append(more[near])
    lost = int(np.count_nonzero(~kept))
    said = f"; {lost} rows left out, as another bank was not logged then" if lost else ""
    return times[kept], np.hstack(columns)[kept], said


def battery_volts(
    path: Path, packs: Mapping[int, tuple[FloatArray, FloatArray]], at: FloatArray
) -> tuple[FloatArray | None, str]:
    """The voltage (N,) at some times of the first battery that measured one, and a doubt about others.

    Packs are times (M,) and voltages (M, 1) by the battery's number; None where none was measured.
    """
    medians = {i: f"{np.median(v[v > 0]):.3g} V" for i, (_, v) in packs.items() if (v > 0).any()}
    if not medians:
        return None, ""
    first = min(medians)
    doubt = ""
    if len(set(medians.values())) > 1:
        listed = ", ".join(f"{i} ({volts}, median)" for i, volts in medians.items())
        doubt = (
            f"{path.name}: batteries {listed} are logged; thrusts are at the voltage of {first}: if another"
            " feeds the thrusters, give a CSV with its 'volts'"
        )
    return hold_last(*packs[first], at)[:, 0], doubt


def battery_amps(packs: Mapping[int, tuple[FloatArray, FloatArray]], at: FloatArray) -> FloatArray | None:
    """The current (N,) at some times of the first battery that measured one [A]; None without any.

    Packs are times (M,) and currents (M, 1) by the battery's number; negative or NaN where none was measured.
    """
    first = min((i for i, (_, amps) in packs.items() if (amps > 0).any()), default=None)
    if first is None:
        return None
    amps = hold_last(*packs[first], at)[:, 0]
    return np.where(amps >= 0, amps, np.nan)


def hold_last(times: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Values (M, …) of rising times (M,) as they held at other times (N,): the last, or the first of all."""
    return values[np.maximum(np.searchsorted(times, at, side="right") - 1, 0)]


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


def read_motion(
    path: Path, outputs: Outputs, vehicle: Vehicle, columns: Mapping[str, str] | None = None
) -> Motion:
    """Motion at the rows of outputs: by their sensors, else by columns of the table that they were read from.

    Columns are ``a_surge`` … and ``v_surge`` …, one a DOF. Raises DemandError for a log that lacks some.
    """
    if outputs.sensors is not None:
        assert outputs.t is not None
        return estimate_motion(path, outputs.sensors, outputs.start + outputs.t, vehicle)
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
