"""Logs of demands and of outputs. Each module here reads one kind of file.

A module has ``SUFFIXES`` of the files it reads ("/" for a folder), and ``read(path, topic) -> Demanded`` of
demands on all six axes (``bench.inputs.demand_csv``), or ``read_outputs(path, vehicle, topic, sensed)`` ->
``Outputs`` (``bench.inputs.outputs``), or both. Tables are read in these two files.
"""

from pathlib import Path

import msgspec
import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle import LARGEST
from alloc.vehicle.geometry import DOF
from bench.inputs.columns import VOLTS
from bench.inputs.demand_csv import Demanded, read_demands, scale_factors
from bench.inputs.frames import turn_to_frame
from bench.inputs.log_files import in_order, reader
from bench.inputs.table import TABLES

GAP = 3.0
"""A step longer than this many median steps is a gap: at least two samples in a row are missing."""


class LogOptions(msgspec.Struct, frozen=True, kw_only=True):
    """Facts from the user that a log does not hold; empty where the user gives none.

    Attributes
    ----------
    topic : of the wrenches, where a bag has several
    frame : frd or flu, where what the log says of its frame, or nothing, is wrong
    columns : the column's name of some DOF, of ``t`` and of ``volts``, where a table's header is not known
    scale : factors of all DOF, or of each [N, N m] over what the log has
    """

    topic: str = ""
    frame: str = ""
    columns: dict[str, str] = {}
    scale: tuple[float, ...] = ()


def read_log(
    path: Path,
    dof: tuple[str, ...],
    options: LogOptions | None = None,
    *,
    frame: str = "frd",
    thrusters: tuple[str, ...] = (),
) -> Demanded:
    """Times and demands in a log, turned into the vehicle's frame; ``said`` tells whether they were turned.

    Parameters
    ----------
    path : the log; ``FILE#TOPIC`` names the topic as well, where no file has that name
    dof : the vehicle's DOF, which become the columns; all others are left out
    options : what the log does not say itself
    frame : frd or flu, that of the vehicle
    thrusters : their names, which columns of limits may have

    Raises
    ------
    FileError where the log can't be read, DemandError where it holds no demands or has not what an option is
    about, NotInstalled where its reader is missing; each with the remedy.
    """
    options = options or LogOptions()
    topic = options.topic
    name, mark, fragment = str(path).rpartition("#")
    if mark and not path.exists():
        path, topic = Path(name), topic or fragment
    if not path.is_dir() and path.suffix.lower() in TABLES:
        if topic:
            raise DemandError(f"{path}: a table has no topic {topic!r}; --columns says which column is what")
        log = read_demands(path, dof, options.columns, thrusters)
    else:
        log = _from_module(path, dof, topic, options)
    taus, turning = turn_to_frame(path, log.taus, dof, log.stated, options.frame, frame)
    said = f"{log.notes}; {turning}" if log.notes else f"{path.name}: {turning}"
    return log._replace(
        taus=taus * scale_factors(options.scale, dof), notes=said, shares=log.shares and not options.scale
    )


def _from_module(path: Path, dof: tuple[str, ...], topic: str, options: LogOptions) -> Demanded:
    """Demands of a log that is no table, in the log's frame.

    Rows that are all NaN, as before a controller runs, are no demands, and left out.
    """
    if path.suffix.lower() == ".bin" and path.exists():
        raise DemandError(
            f"{path}: ArduPilot logs what was sent; `demands --from-outputs -o` makes a CSV of it"
        )
    module = reader(path, "read", "log")
    if options.columns:
        raise DemandError(f"{path}: has no columns; --columns is for tables, leave it out")
    log: Demanded = module.read(path, topic)
    assert log.t is not None
    order = in_order(path, log.t)  # messages may arrive late
    t, taus = log.t[order], log.taus[order]
    moved = np.nan_to_num(taus)
    others = [axis for axis, column in zip(DOF, moved.T, strict=True) if column.any() and axis not in dof]
    taus = taus[:, [DOF.index(axis) for axis in dof]]
    there = ~np.isnan(taus).all(axis=1)
    if not there.any():
        raise DemandError(f"{path}: holds no demands; record the demanded wrench")
    t, taus = t[there] - t[there][0], taus[there]
    bad = np.flatnonzero(~(np.abs(taus) <= LARGEST).all(axis=1))
    if bad.size:
        raise DemandError(
            f"{path}: the wrench at t = {t[bad[0]]:.3f} s is not finite, or above {LARGEST:g}; cut it out"
        )
    parts = [f"left out: {', '.join(others)}, which the vehicle does not have"] if others else []
    parts += [] if there.all() else [f"{np.count_nonzero(~there)} rows without a demand"]
    parts += [log.notes] if log.notes else []
    said = f"{path.name}: {'; '.join(parts)}" if parts else ""
    return Demanded(t, taus, said, stated=log.stated, shares=log.shares)


def log_for(vehicle: Vehicle, path: Path, options: LogOptions | None = None) -> Demanded:
    """Demands of a log on a vehicle, in its DOF and its frame; raises what ``read_log`` does.

    Voltages that no limits follow are left out with a doubt, unless the user named their column.
    """
    options = options or LogOptions()
    log = read_log(path, vehicle.dof, options, frame=vehicle.frame, thrusters=vehicle.names)
    doubts = [log.doubt]
    if log.shares:
        doubts.append(f"{path.name}: setpoints are shares of 1, taken for N and N m; --scale says what 1 is")
    if vehicle.by_volts is not None and VOLTS not in log.columns and log.others:
        said = "limits follow no voltage without a column 'volts', or --columns 'volts=NAME [V]'"
        log = log._replace(notes=f"{log.notes}; {said}")
    columns = log.columns
    if vehicle.by_volts is None and VOLTS in columns and VOLTS not in options.columns:
        doubts.append(
            f"{path.name}: 'volts' is left out, as {vehicle.name} has no limits by voltage; if they follow"
            " it, add 'volts' to its file"
        )
        columns = {name: values for name, values in columns.items() if name != VOLTS}
    return log._replace(columns=columns, doubt="; ".join(filter(None, doubts)))


def rate_hz(t: FloatArray | None) -> float | None:
    """Sampling rate [Hz] of times (N,) [s]: one over the median step; None without times or steps."""
    if t is None or len(t) < 2:
        return None
    step = float(np.median(np.diff(t)))
    return 1 / step if step > 0 else None


def after_gaps(t: FloatArray | None) -> tuple[int, ...]:
    """Demands of times (N,) [s] that follow a gap: a step longer than ``GAP`` median ones."""
    if rate_hz(t) is None or t is None:
        return ()
    steps = np.diff(t)
    return tuple((np.flatnonzero(steps > GAP * np.median(steps)) + 1).tolist())
