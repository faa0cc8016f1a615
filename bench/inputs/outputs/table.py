"""CSV with a column of commands for each thruster, as ``thrustbench allocate --esc`` writes them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from bench.inputs.columns import VOLTS, Column, assign, units_said
from bench.inputs.delimited import TABLES, is_blank, read_table
from bench.inputs.demand_csv import seconds
from bench.inputs.frames import id_column, of_table
from bench.inputs.log_limits import FAR, IN_MILLIVOLTS, like_volts, limit_columns
from bench.inputs.outputs import Outputs
from bench.inputs.understood import attitude, like_angles, passed_over, understood, without_time
from bench.inputs.units import TIME

SUFFIXES = TABLES
COLUMNS = True
"""``read`` takes names of columns."""
LARGEST = 1e20
"""Bound on every number, times in ns among them."""
REST = "t, nanoseconds"
"""Where a stamp's nanoseconds stand in a column of their own."""


def read(path: Path, vehicle: Vehicle, columns: Mapping[str, str] | None = None) -> Outputs:
    """Columns ``u0``, ``u1``, … and, where there are such, times, ``volts`` and demands, named as in any log.

    A row whose cells of demands are all empty, or NaN, has commands and no demand; one without commands is
    left out. ``columns`` are names that the header does not tell, as of any log.
    """
    given = columns or {}
    table = read_table(path)
    place = f"{path}: line {table.line}"
    names = [f"u{i}" for i in range(vehicle.n)]
    missing = [name for name in names if table.header.count(name) != 1]
    if missing:
        raise DemandError(
            f"{place}: no one column {missing[0]!r}; give u0 … u{vehicle.n - 1}, the command of each thruster"
        )
    found = assign(place, table.header, table.units, vehicle.dof, given, every=False)
    angles = attitude(found, given)
    found = {quantity: column for quantity, column in found.items() if quantity not in angles}
    asked = [axis for axis in vehicle.dof if axis in found]
    places = {name: table.header.index(name) for name in names}
    commands = set(places.values())
    limits = limit_columns(place, table.header, table.units, given=given, found=found)
    volts = {name: column for name, column in limits.items() if name == VOLTS}
    places |= {quantity: column.place for quantity, column in (volts | found).items()}
    if TIME in found and (rest := found[TIME].rest) is not None:
        places[REST] = rest
    named = tuple(found[axis].name for axis in asked)
    framing, ids = id_column(table.header, named), set[str]()
    rows, blank, alone = [], 0, 0
    for line, cells in table.rows:
        if len(cells) != len(table.header):
            raise table.refused(
                line, f"has {len(cells)} cells under {len(table.header)} columns; mend that row"
            )
        if is_blank(cells[places[name]] for name in names):
            blank += 1
            alone += not is_blank(cells[places[axis]] for axis in asked)
            continue
        ids |= framing.ids(cells)
        unasked = set(asked) if is_blank(cells[places[axis]] for axis in asked) else set()
        rows.append(
            [
                np.nan if name in unasked else table.number(line, name, cells[at], LARGEST)
                for name, at in places.items()
            ]
        )
    values = dict(zip(places, np.array(rows).reshape(len(rows), len(places)).T, strict=True))
    t, unit = (None, "")
    if TIME in found and rows:
        t, unit = seconds(values[TIME], table.stamped(found[TIME]), values.get(REST))
    if t is not None and (np.diff(t) < 0).any():
        raise DemandError(f"{path}: times in {found[TIME].name[:40]!r} go back; sort the rows")
    said = understood(path, table, found, volts, unit, also={*commands, framing.read(ids)}) or path.name
    said += f"{';' if ': ' in said else ':'} {names[0]} … {names[-1]} are the commands"
    if blank:
        said += f"; {blank} rows without commands"
    if alone:
        said += f", {alone} of them with demands, which are not compared: fill commands forward"
    if angles:
        kept = ",".join(f"{axis}={name}" for axis, name in angles.items())
        said += f"; {', '.join(angles.values())} without a force may be attitude; --columns '{kept}' if N m"
    if VOLTS not in places and (unread := like_volts(table.header)):
        named_so = f"--columns '{VOLTS}={unread[:40]}'"
        said += f"; thrusts follow no voltage: if {unread[:40]!r} is the battery's, {named_so}"
    battery = values[VOLTS] * volts[VOLTS].factor if volts else None
    frame, why, framed = of_table(path, table.frame, ids)
    return Outputs(
        t,
        np.column_stack([values[name] for name in names]),
        battery,
        _demands(vehicle.dof, found, values) if asked else None,
        said=said,
        frame=frame,
        why=why,
        framed=framed,
        named=named,
        with_unit=units_said(found, given, dates=table.times == "dates"),
        doubt=_in_millivolts(path, battery, vehicle)
        or passed_over(path, table, found, given, places.values())
        or like_angles(path, found, given)
        or without_time(path, table, found),
    )


def _in_millivolts(path: Path, volts: FloatArray | None, vehicle: Vehicle) -> str:
    """A doubt about voltages (N,) far beyond those of the ESCs' curves."""
    most = max((esc.volts.max() for esc in vehicle.esc), default=np.nan)
    if volts is None or not len(volts) or not np.median(volts) > FAR * most:
        return ""
    return f"{path.name}: {volts[0]:g} V, where curves end at {most:g} V; {IN_MILLIVOLTS}"


def _demands(dof: Sequence[str], found: Mapping[str, Column], values: Mapping[str, FloatArray]) -> FloatArray:
    """Demands (N, k) as the log has them, NaN on axes that have none."""
    none = np.full(len(values["u0"]), np.nan)
    return np.column_stack(
        [values[axis] * (found[axis].factor or 1.0) if axis in found else none for axis in dof]
    )
