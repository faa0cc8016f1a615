"""Demands read from tables, and demands, thrusts and commands written as CSV."""

import csv
import io
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import isnan, nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Allocation, Status, Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.live.azimuths import with_angles
from alloc.vehicle import LARGEST
from alloc.vehicle.esc import Made
from alloc.vehicle.frame import turned
from alloc.vehicle.geometry import MOMENTS
from bench.inputs.columns import (
    TIME,
    VOLTS,
    Column,
    assign,
    columns_option,
    describe_columns,
    find_spellings,
    key,
    possible_angles,
)
from bench.inputs.frames import Stated, frame_columns, frame_comment, table_frame
from bench.inputs.log_limits import limit_columns
from bench.inputs.table import LARGEST as LATEST
from bench.inputs.table import Cells, is_blank, is_number, read_table


class Demanded(NamedTuple):
    """Demands of a log.

    Attributes
    ----------
    t : (N,) [s], never decreasing; None where the log has no times
    taus : (N, k) demands in the order of the vehicle's DOF [N, N m]
    notes : how the file was understood, in a line; empty for a table of demands and times as this program
        writes it
    columns : (N,) columns about limits by name (``bench.inputs.log_limits``), ``volts`` [V], ``f0_min`` [N]
    stated : the frame that the log states
    doubt : what may be wrong, in a line; empty for nothing
    shares : whether taus are known to be shares of what the vehicle can do [-]
    others : whether a table has columns that are left out
    u : (N, n) commands, where columns of these were asked for
    axes : of which a table has demands
    """

    t: FloatArray | None
    taus: FloatArray
    notes: str = ""
    columns: Mapping[str, FloatArray] = {}
    stated: Stated = Stated()
    doubt: str = ""
    shares: bool = False
    others: bool = False
    u: FloatArray | None = None
    axes: tuple[str, ...] = ()


def read_demands(
    path: Path,
    dof: tuple[str, ...],
    columns: Mapping[str, str] | None = None,
    thrusters: Sequence[str] = (),
    commands: Sequence[str] = (),
) -> Demanded:
    """Demands from a table with known headers, or with ``columns`` that the user names, as they stand.

    Parameters
    ----------
    path : the file: one row a demand, limits (``bench.inputs.log_limits``), and further columns, left out
    dof : the vehicle's controlled DOF; each needs a column
    columns : names of columns by DOF; ``t`` for the time, ``volts``
    thrusters : names of the vehicle's thrusters, which columns of limits may have
    commands : names of columns of outputs. A row needs these, and may have demands; moments without a force
        are more often an attitude, and taken where the user names them only; of limits only volts count

    Raises
    ------
    FileError where the file is no table of numbers, DemandError where the numbers are no demands of this
    vehicle; both name file, line, column and remedy.
    """
    table, given = read_table(path), columns or {}
    head, place, header = table.named, table.named.place, table.header
    if missing := [name for name in commands if header.count(name) != 1]:
        raise DemandError(
            f"{place}: no one column {missing[0]!r}; give {commands[0]} … {commands[-1]}, one a thruster"
        )
    if not any(header):
        raise DemandError(f"{place}: the file is empty; give a header '{','.join(dof)}' and one row a demand")
    found = assign(head, dof, given, every=not commands)
    angles: dict[str, str] = {}
    if commands and {*found} <= {TIME, *MOMENTS}:
        angles = possible_angles({axis: found[axis] for axis in found if axis not in (TIME, *given)})
    found = {quantity: column for quantity, column in found.items() if quantity not in angles}
    axes = [axis for axis in dof if axis in found]
    limits = limit_columns(head, thrusters, given, found)
    limits = {name: column for name, column in limits.items() if name == VOLTS or not commands}
    used = {name: header.index(name) for name in commands}
    used |= {name: column.place for name, column in (limits | found).items()}
    needed, demands = [used[name] for name in commands or axes], [used[axis] for axis in axes]
    values, lines, blank, cells = read_rows(table, used, found.get(TIME), needed, axes if commands else ())
    if not lines and not commands:
        raise DemandError(f"{path}: holds no demands; give one row a demand below the header")
    t = times(table, found.get(TIME), values, lines, given)
    also = {*(used[name] for name in commands), *(i for i in cells if cells[i])}
    parts = [describe_columns(path.name, header, found, limits, also)]
    parts += [f"{commands[0]} … {commands[-1]} are the commands"] if commands else []
    if blank:
        parts.append(f"{blank} rows without {'commands' if commands else 'a demand'}")
    alone = sum(
        is_blank(row[i] for i in needed) and not is_blank(row[i] for i in demands) for _, row in table.rows
    )
    if alone:
        parts[-1] += f", {alone} of them with demands, which are not compared: fill commands forward"
    if angles:
        parts.append(f"{', '.join(angles.values())} without a force may be attitude")
        parts.append(f"{columns_option(angles)} if N m")
    said = "; ".join(filter(None, parts))
    names = [found[axis].name for axis in axes]
    none = np.full(len(lines), nan)
    return Demanded(
        t,
        np.column_stack([values[axis] * found[axis].factor if axis in found else none for axis in dof]),
        said if parts[0] or not said else f"{path.name}: {said}",
        {name: values[name] * column.factor for name, column in limits.items()},
        table_frame(table.text, header, cells, names),
        "; ".join(filter(None, (_steps(path, t, found.get(TIME), table), _repeats(path, t, values)))),
        shares=any(wrench.shares for wrench in find_spellings(names)),
        others=len(header) > len({*used.values(), *also}),
        u=np.column_stack([values[name] for name in commands]) if commands else None,
        axes=tuple(axes),
    )


SLOW = 2.0
"""Step from which times without a unit are doubted: demands are logged faster [s]."""
NANOSECONDS = "t, nanoseconds"
"""Key of a stamp's nanoseconds that stand in a column of their own."""


def read_rows(
    table: Cells,
    used: Mapping[str, int],
    time: Column | None,
    needed: Collection[int],
    optional: Collection[str] = (),
) -> tuple[dict[str, FloatArray], list[int], int, dict[int, set[str]]]:
    """Numbers (N,) by name, lines of their rows, how many rows are blank, and cells that may state a frame.

    Parameters
    ----------
    used, time : places of columns by name; the column of the time, None without one
    needed : places of which a row that is blank in all is left out
    optional : names whose cells may be blank together, which gives NaN
    """
    places = dict(used) | ({} if time is None or time.rest is None else {NANOSECONDS: time.rest})
    first = table.rows[0][1] if table.rows else []
    cells: dict[int, set[str]] = {i: set() for i in frame_columns(table.header, first, {*places.values()})}
    rows, lines, blank = [], [], 0
    for line, row in table.checked_rows():
        if is_blank(row[place] for place in needed):  # a line of another sensor
            blank += 1
            continue
        for place, said in cells.items():
            said.add(row[place].strip().lower())
        absent = {*optional} if is_blank(row[places[name]] for name in optional) else set()
        lines.append(line)
        rows.append(
            [
                nan
                if name in absent
                else table.number(
                    line,
                    TIME if name == NANOSECONDS else name,
                    row[place],
                    LATEST if name in (TIME, NANOSECONDS) else LARGEST,
                )
                for name, place in places.items()
            ]
        )
    values = np.array(rows).reshape(len(rows), len(places)).T
    return dict(zip(places, values, strict=True)), lines, blank, cells


def times(
    table: Cells,
    column: Column | None,
    values: Mapping[str, FloatArray],
    lines: Sequence[int],
    given: Mapping[str, str],
) -> FloatArray | None:
    """Times (N,) [s], None without a column; raises FileError without a unit, DemandError if they go back."""
    if column is None or not lines:
        return None
    t = values[TIME] * table.time_factor(column, given)
    if column.rest is not None:
        t = values[TIME] - values[TIME][0] + (values[NANOSECONDS] - values[NANOSECONDS][0]) * 1e-9
    if (back := np.flatnonzero(np.diff(t) < 0)).size:
        raise DemandError(
            f"{table.path}, line {lines[back[0] + 1]}: t goes back from {t[back[0]]:g} to {t[back[0] + 1]:g}"
            " s; put rows in time order"
        )
    return t


def _steps(path: Path, t: FloatArray | None, column: Column | None, table: Cells) -> str:
    """A doubt about a column ``t`` without a unit that has steps of no log of demands in s."""
    if t is None or column is None or column.unit or key(column.name) != TIME or table.dates:
        return ""
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if not step > SLOW:
        return ""
    option = columns_option({TIME: f"{column.name} [ms]"})
    return f"{path.name}: steps of t are {step:g} s, as no unit is stated; if t is in ms: {option}"


def _repeats(path: Path, t: FloatArray | None, values: Mapping[str, FloatArray]) -> str:
    """A doubt about rows that duplicate the row before, time included, or most of which have its time."""
    if t is None or len(t) < 3:
        return ""
    if np.median(np.diff(t)) == 0:
        return f"{path.name}: most rows have the previous row's time, so no rate is known; --columns 't=NAME'"
    twice = int((np.diff(list(values.values()), axis=1) == 0).all(axis=0).sum())
    return f"{path.name}: {twice} rows duplicate the previous row and are counted twice" if twice else ""


def csv_text(header: Sequence[str], rows: Iterable[Iterable[str | float]]) -> str:
    """A header and rows as CSV; numbers are the shortest that read back as the same double."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue()


def format_demands(
    t: FloatArray | None,
    taus: FloatArray,
    dof: tuple[str, ...],
    columns: Mapping[str, FloatArray] | None = None,
    *,
    frame: str = "frd",
) -> str:
    """The CSV of times (N,) [s] or None, demands (N, k) and columns about limits, for ``read_demands``.

    A comment above the header says the frame that the demands are in.
    """
    further = columns or {}
    header = (*(() if t is None else ("t",)), *dof, *further)
    table = [*(() if t is None else (t,)), *taus.T, *further.values()]
    return frame_comment(frame) + csv_text(header, np.column_stack(table).tolist())


def parse_scale(text: str, option: str = "--scale") -> tuple[float, ...]:
    """Factors from ``"200"``, one for all DOF, or ``"200,200,50"``, one each; raises DemandError."""
    cells = text.split(",") if text else []
    factors = tuple(float(cell) for cell in cells if is_number(cell))
    # 0 would ask for nothing, and a sign is the frame's.
    if len(factors) < len(cells) or not all(factor > 0 for factor in factors):
        raise DemandError(
            f"{option} {text[:60]!r}: give one number above 0, or one for each DOF, as in 200,200,50"
        )
    return factors


def scale_factors(scale: Sequence[float], dof: Sequence[str], option: str = "--scale") -> FloatArray:
    """The factor (k,) of each DOF, 1 without any; raises DemandError for another number of them."""
    if len(scale) not in (0, 1, len(dof)):
        raise DemandError(
            f"{option} has {len(scale)} factors, expected one, or one for each of {', '.join(dof)}"
        )
    return np.array(np.broadcast_to(scale or 1.0, len(dof)), dtype=np.float64)


def format_thrusts(
    answers: Sequence[Allocation],
    header: Sequence[str],
    further: Mapping[str, Sequence[float]] | None = None,
    *,
    frame: str = "",
) -> str:
    """The CSV of answers, a row each: status, thrusts [N] (``nan`` where there are none), shares if any.

    ``header`` names the n columns of thrusts; ``further`` columns stand behind all others, and behind these
    a column with the ``frame`` of wrenches among them, if any. A share that an answer does not say is
    ``nan``. Numbers have ten significant digits: a nanonewton of a newton. Raises DemandError where two
    columns would have one name.
    """
    levels = max(len(answer.share) for answer in answers)  # a plug-in may say shares of some answers only
    shares = [f"share{i}" for i in range(levels)]
    behind = further or {}
    framed = [frame] if frame else []
    columns = ["status", *header, *shares, *behind, *(["frame"] if frame else [])]
    if twice := [name for i, name in enumerate(columns) if name in columns[:i]]:
        raise DemandError(
            f"--names: two columns would be '{twice[0]}'; leave it out, or rename that thruster"
        )
    rows = (
        [
            Status(a.status).name,
            *(
                f"{number + 0.0:.10g}"
                for number in (
                    *a.f.tolist(),
                    *a.share,
                    *[nan] * (levels - len(a.share)),
                    *(c[i] for c in behind.values()),
                )
            ),
            *framed,
        ]
        for i, a in enumerate(answers)
    )
    return csv_text(columns, rows)


def polar_columns(vehicle: Vehicle, answers: Sequence[Allocation]) -> dict[str, list[float]]:
    """Columns force0 [N] and angle0 [deg] of each thruster that turns, by its number; NaN without thrusts.

    Angles go the shortest way round from those of the last answer, and on beyond 180, or through the sector.
    """
    turning = [i for i, components in enumerate(vehicle.actuators) if len(components) > 1]
    columns = {f"{name}{i}": list[float]() for i in turning for name in ("force", "angle")}
    last = np.full(len(vehicle.actuators), nan)
    for answer in answers:
        said = with_angles(vehicle, answer)
        last = said.nearest_angles(last)
        for i in turning:
            force = float(said.forces[i])
            columns[f"force{i}"].append(force)
            columns[f"angle{i}"].append(nan if isnan(force) else float(last[i]))
    return columns


def esc_columns(
    vehicle: Vehicle,
    answers: Sequence[Allocation],
    t: FloatArray | None = None,
    volts: FloatArray | None = None,
    f_min: FloatArray | None = None,
    f_max: FloatArray | None = None,
    frame: str = "",
    cap: Sequence[float] | None = None,
) -> tuple[dict[str, list[float]], str]:
    """Columns u0, u1, … of commands, made_surge, … of the wrench T P f that they make [N, N m], and a doubt.

    One entry an answer, whose voltage (N,) [V] and limits (N, n) [N] are given, or the vehicle's. Times (N,)
    [s], since the first one, and voltages stand behind, so that what was sent is a log of outputs. The wrench
    is in ``frame``, or the vehicle's. The doubt is about voltages at which nothing was measured, empty
    without any. No row draws more than its ``cap`` [A].
    """
    f = np.array([answer.f for answer in answers]).reshape(len(answers), vehicle.n)
    wired = vehicle.commands(f, volts, f_min=f_min, f_max=f_max, cap=cap)
    made = wired.f @ vehicle.TP.T
    if frame not in ("", vehicle.frame):
        made = turned(made.T, vehicle.dof).T
    columns = {f"u{i}": wired.u[:, i].tolist() for i in range(vehicle.n)}
    columns |= {f"made_{axis}": made[:, row].tolist() for row, axis in enumerate(vehicle.dof)}
    known = {"t": None if t is None else t - t[0], "volts": volts}
    columns |= {name: column.tolist() for name, column in known.items() if column is not None}
    outside = int((wired.status == Made.OUTSIDE_TABLE).any(axis=1).sum())
    if not outside:
        return columns, ""
    doubt = f"at the voltage of {outside} of {len(f)} rows no curve was measured: the nearest one is taken"
    return columns, f"{doubt}, also for made_{vehicle.dof[0]}, …"
