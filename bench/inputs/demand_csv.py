"""Reads demands from CSV and writes thrusts as CSV, for users' scripts and from loggers."""

from collections.abc import Mapping, Sequence, Set
from math import nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Allocation, Status
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle import LARGEST
from bench.inputs.columns import VOLTS, Column, assign, units_said
from bench.inputs.csv_text import csv_text, is_number
from bench.inputs.delimited import is_blank, read_table
from bench.inputs.frames import frame_comment, id_column, of_table
from bench.inputs.log_limits import like_volts, limit_columns
from bench.inputs.understood import like_angles, passed_over, understood, without_time
from bench.inputs.units import SECONDS, TIME

LATEST = 1e20
"""Bound on times, in any unit: a date in ns is 1.7e18."""


class Demanded(NamedTuple):
    """Demands of a log.

    Attributes
    ----------
    t : (N,) [s], never decreasing; None where the log has no times
    taus : (N, k) demands in the order of the vehicle's DOF [N, N m]
    said : how the file was understood, in a line; empty for a table of demands and times as this program
        writes it
    columns : (N,) columns about limits by name (``bench.inputs.log_limits``), ``volts`` [V], ``f0_min`` [N]
    frame, why : what a comment in the file or its frame_ids say, and which of them; empty where none does
    framed : what may be wrong about that, in a line, which --frame settles; empty for nothing
    named : the names of the demands' columns
    doubt : what else may be wrong, in a line; empty for nothing
    shares : whether taus are known to be shares of what the vehicle can do [-]
    with_unit : quantities whose unit the log or the user says, so that no other one is guessed
    converted : (k,) names of columns whose unit was another, which is N or N m now; empty for others
    """

    t: FloatArray | None
    taus: FloatArray
    said: str = ""
    columns: Mapping[str, FloatArray] = {}
    frame: str = ""
    why: str = ""
    framed: str = ""
    named: tuple[str, ...] = ()
    doubt: str = ""
    shares: bool = False
    with_unit: Set[str] = frozenset()
    converted: tuple[str, ...] = ()


def read_demands(
    path: Path,
    dof: tuple[str, ...],
    columns: Mapping[str, str] | None = None,
    thrusters: Sequence[str] = (),
    *,
    by_volts: bool = False,
) -> Demanded:
    """Demands from a table whose header names the DOF, in any order and much as loggers do, as they stand.

    Parameters
    ----------
    path : the file: one row a demand; commas, semicolons, tabs or blanks between cells, comments and blank
        lines anywhere, limits (``bench.inputs.log_limits``), and further columns, which are left out
    dof : the vehicle's controlled DOF; each needs a column
    columns : names of columns that the header does not tell, by DOF; ``t`` for the time, ``volts``
    thrusters : names of the vehicle's thrusters, which columns of limits may have
    by_volts : whether the vehicle's limits follow the voltage

    Raises
    ------
    FileError where the file is no table of numbers, DemandError where the numbers are no demands of this
    vehicle; both name file, line, column and remedy.
    """
    table = read_table(path)
    place = f"{path}: line {table.line}"
    if not any(table.header):
        raise DemandError(f"{place}: the file is empty; give a header '{','.join(dof)}' and one row a demand")
    given = columns or {}
    found = assign(place, table.header, table.units, dof, given)
    used = [
        (quantity, column.place, LATEST if quantity == TIME else LARGEST)
        for quantity, column in found.items()
    ]
    limits = limit_columns(place, table.header, table.units, thrusters, given, found)
    used += [(name, column.place, LARGEST) for name, column in limits.items()]
    rest = found[TIME].rest if TIME in found else None
    used += [] if rest is None else [(TIME, rest, LATEST)]
    named = tuple(found[axis].name for axis in dof)
    framing, ids = id_column(table.header, named), set[str]()
    numbers: list[list[float]] = []
    lines: list[int] = []
    blank = 0
    for line, row in table.rows:
        if len(row) != len(table.header):
            raise DemandError(
                f"{path}: line {line}: {len(row)} cells under {len(table.header)} columns; give one a column"
            )
        if is_blank(row[found[axis].place] for axis in dof):  # a line of another sensor
            blank += 1
            continue
        lines.append(line)
        ids |= framing.ids(row)
        numbers.append([table.number(line, quantity, row[place], most) for quantity, place, most in used])
    if not numbers:
        raise DemandError(f"{path}: holds no demands; give one row a demand below the header")
    values = np.array(numbers)
    taus = values[:, : len(dof)] * [found[axis].factor for axis in dof]
    times, unit = (None, "")
    if TIME in found:
        stamp = table.stamped(found[TIME])
        times, unit = seconds(values[:, len(dof)], stamp, None if rest is None else values[:, -1])
    if times is not None and (back := np.flatnonzero(np.diff(times) < 0)).size:
        raise DemandError(
            f"{path}: line {lines[back[0] + 1]}: t goes back from {times[back[0]]:g} to"
            f" {times[back[0] + 1]:g} s; put rows in time order"
        )
    said = understood(path, table, found, limits, unit, blank, also={framing.read(ids)})
    by_name = {
        name: values[:, len(found) + i] * column.factor for i, (name, column) in enumerate(limits.items())
    }
    unread = like_volts(table.header) if by_volts and VOLTS not in limits else ""
    doubts = (
        passed_over(path, table, found, given, [column.place for column in limits.values()]),
        like_angles(path, found, given),
        without_time(path, table, found),
        _still(path, times) or _doubled(path, times, values),
        _without_volts(path, unread),
    )
    framed = of_table(path, table.frame, ids)
    converted = tuple(found[axis].name if found[axis].factor != 1 else "" for axis in dof)
    doubt = "; ".join(filter(None, doubts))
    with_unit = units_said(found, given, dates=table.times == "dates")
    return Demanded(
        times, taus, said, by_name, *framed, named, doubt, with_unit=with_unit, converted=converted
    )


def _still(path: Path, times: FloatArray | None) -> str:
    """A doubt about times most of which are those of the row before: they give no rate."""
    if times is None or len(times) < 3 or np.median(np.diff(times)) > 0:
        return ""
    return f"{path.name}: most rows have the time of the row before, so no rate is known; --columns t=NAME"


def _doubled(path: Path, times: FloatArray | None, values: FloatArray) -> str:
    """A doubt about rows that duplicate the previous row, its time included."""
    twice = 0 if times is None else int((np.diff(values, axis=0) == 0).all(axis=1).sum())
    if not twice:
        return ""
    return f"{path.name}: {twice} rows duplicate the previous row and are counted twice"


def _without_volts(path: Path, unread: str) -> str:
    """A doubt about limits that don't follow a voltage that the log may have in the column ``unread``."""
    if not unread:
        return ""
    return (
        f"{path.name}: limits follow no voltage, since no column is called 'volts';"
        f" if {unread[:40]!r} is the battery's, --columns 'volts={unread[:40]}'"
    )


def seconds(values: FloatArray, column: Column, rest: FloatArray | None = None) -> tuple[FloatArray, str]:
    """Times [s], and the unit that their size tells where nothing else does: a date in ms is above 1e11.

    ``rest`` are nanoseconds beyond ``values``, whole seconds.
    """
    if rest is not None:
        return values - values[0] + (rest - rest[0]) * 1e-9, ""
    if column.factor is not None:
        return values * column.factor, ""
    for unit, least in (("ns", 1e17), ("us", 1e14), ("ms", 1e11)):
        if abs(values[0]) > least:
            return (values - values[0]) * SECONDS[unit], unit
    return values, "s"


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


def parse_scale(text: str) -> tuple[float, ...]:
    """Factors from ``"200"``, one for all DOF, or ``"200,200,50"``, one each; raises DemandError."""
    cells = text.split(",") if text else []
    factors = tuple(float(cell) for cell in cells if is_number(cell))
    # 0 would ask for nothing, and a sign is the frame's.
    if len(factors) < len(cells) or not all(factor > 0 for factor in factors):
        raise DemandError(
            f"--scale {text[:60]!r}: give one number above 0, or one for each DOF, as in 200,200,50"
        )
    return factors


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
