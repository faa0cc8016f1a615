"""Logs of demands. Each module here reads one kind of log.

A module has ``SUFFIXES`` of the files it reads ("/" for a folder) and ``read(path, topic) -> Log``.
``bench.inputs.demand_csv`` reads tables.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle import LARGEST
from alloc.vehicle.geometry import DOF
from bench.inputs.by_suffix import reader
from bench.inputs.columns import VOLTS
from bench.inputs.delimited import TABLES
from bench.inputs.demand_csv import Demanded, read_demands
from bench.inputs.frames import doubted, frame_of, met
from bench.inputs.shares import like_shares
from bench.inputs.time_order import in_order
from bench.inputs.units import TIME

GAP = 3.0
"""A step longer than this many median steps is a gap: at least two samples in a row are missing."""


class Log(NamedTuple):
    """The wrenches in a bag or a ULog.

    Attributes
    ----------
    t : (N,) times since the first one [s]
    taus : (N, 6) wrenches, surge to yaw [N, N m]
    frame : frd or flu, the frame of taus
    why : what says so
    framed : what may be wrong about the frame, in a line, which --frame settles; empty for nothing
    shares : whether taus are known to be shares of what the vehicle can do [-], which only --scale turns
    odd : what else is to be said of the log, to be added to another text
    """

    t: FloatArray
    taus: FloatArray
    frame: str
    why: str
    framed: str = ""
    shares: bool = False
    odd: str = ""


class LogOptions(msgspec.Struct, frozen=True, kw_only=True):
    """Facts from the user that a log does not hold; empty where the user gives none.

    Attributes
    ----------
    topic : of the wrenches, where a bag has several
    frame : frd or flu, where what the log says of its frame, or nothing, is wrong
    columns : the column's name of some DOF, of ``t`` and of ``volts``, where a table's header does not tell
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
    thrusters: Sequence[str] = (),
    by_volts: bool = False,
) -> Demanded:
    """Times and demands in a log, turned into the vehicle's frame; ``said`` tells whether they were turned.

    Parameters
    ----------
    path : the log; ``FILE#TOPIC`` names the topic as well, where no file has that name
    dof : the vehicle's DOF, which become the columns; all others are left out
    options : what the log does not say itself
    frame : frd or flu, that of the vehicle
    thrusters : their names, which columns of limits may have
    by_volts : whether the vehicle's limits follow the voltage

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
        table = read_demands(path, dof, options.columns, thrusters, by_volts=by_volts)
        given, why = frame_of(path, options.frame, table.frame, table.why, frame, table.named)
        taus, turning = met(table.taus, dof, given, why, frame)
        said = f"{table.said}; {turning}" if table.said else f"{path.name}: {turning}"
        framed = doubted(path, options.frame, table.frame, table.framed, table.named, frame)
        doubt = "; ".join(filter(None, (framed, table.doubt, _twice(path, table, options))))
        return table._replace(taus=_scaled(taus, dof, options.scale), said=said, doubt=doubt)
    if path.suffix.lower() == ".bin" and path.exists():
        raise DemandError(
            f"{path}: ArduPilot logs what was sent; `demands --from-outputs -o` makes a CSV of it"
        )
    module = reader(__name__, path, "log", TABLES[:-1])
    if options.columns:
        raise DemandError(f"{path}: has no columns; --columns is for tables, leave it out")
    log: Log = module.read(path, topic)
    t, taus, left_out, blank = _checked(path, log, dof)
    given, why = frame_of(path, options.frame, log.frame, log.why, frame)
    taus, turning = met(taus, dof, given, why, frame)
    said = f"{path.name}: {turning}{log.odd}"
    if left_out:
        said += f"; left out: {', '.join(left_out)}, which the vehicle does not have"
    if blank:
        said += f"; {blank} rows without a demand"
    doubt = "" if options.frame else log.framed
    shares = log.shares and not options.scale
    taus = _scaled(taus, dof, options.scale)
    return Demanded(t, taus, said, doubt=doubt, shares=shares, with_unit={TIME})


def log_for(vehicle: Vehicle, path: Path, options: LogOptions | None = None) -> Demanded:
    """Demands of a log on a vehicle, in its DOF and its frame; raises what ``read_log`` does.

    Voltages that no limits follow are left out with a doubt, unless the user named their column.
    """
    options = options or LogOptions()
    by_volts = vehicle.by_volts is not None
    log = read_log(
        path, vehicle.dof, options, frame=vehicle.frame, thrusters=vehicle.names, by_volts=by_volts
    )
    if log.shares:
        doubt = f"{path.name}: setpoints are shares of 1, taken for N and N m; --scale says what 1 is"
        log = _doubting(log, doubt)
    elif not options.scale and not log.with_unit & {*vehicle.dof}:
        log = _doubting(log, like_shares(path, vehicle, log.taus))
    if by_volts or VOLTS not in log.columns or VOLTS in options.columns:
        return log
    doubt = (
        f"{path.name}: 'volts' is left out, as {vehicle.name} has no limits by voltage; if they follow it,"
        " add 'volts' to its file"
    )
    columns = {name: values for name, values in log.columns.items() if name != VOLTS}
    return _doubting(log._replace(columns=columns), doubt)


def _twice(path: Path, table: Demanded, options: LogOptions) -> str:
    """A doubt about a factor on top of one that a column's unit says."""
    factors = options.scale * (len(table.converted) if len(options.scale) == 1 else 1)
    # ``_scaled`` refuses a scale of another length.
    pairs = zip(table.converted, factors, strict=False)
    name = next((name[:40] for name, factor in pairs if name and factor != 1), "")
    if not name:
        return ""
    return f"{path.name}: {name!r} is in N or N m by its unit already; --scale multiplies that once more"


def _doubting(log: Demanded, doubt: str) -> Demanded:
    return log._replace(doubt="; ".join(filter(None, (log.doubt, doubt))))


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


def _scaled(taus: FloatArray, dof: tuple[str, ...], scale: tuple[float, ...]) -> FloatArray:
    if len(scale) > 1 and len(scale) != len(dof):
        raise DemandError(f"--scale has {len(scale)} factors; give one, or one for each of {', '.join(dof)}")
    return taus * np.array(scale) if scale else taus


def _checked(path: Path, log: Log, dof: tuple[str, ...]) -> tuple[FloatArray, FloatArray, list[str], int]:
    """Times, demands on the axes of ``dof``, other axes that were asked for something, rows that are all NaN.

    These, as before a controller runs, are no demands in a table either, and left out.
    """
    order = in_order(path, log.t)  # messages may arrive late
    t, taus = log.t[order], log.taus[order]
    asked = np.nan_to_num(taus)
    left_out = [axis for axis, some in zip(DOF, asked.T, strict=True) if some.any() and axis not in dof]
    taus = taus[:, [DOF.index(axis) for axis in dof]]
    given = ~np.isnan(taus).all(axis=1)
    if not given.any():
        raise DemandError(f"{path}: holds no demands; record the demanded wrench")
    t, taus = t[given] - t[given][0], taus[given]
    bad = np.flatnonzero(~(np.abs(taus) <= LARGEST).all(axis=1))
    if bad.size:
        raise DemandError(
            f"{path}: the wrench at t = {t[bad[0]]:.3f} s is not finite, or above {LARGEST:g}; cut it out"
        )
    return t, taus, left_out, int(np.count_nonzero(~given))
