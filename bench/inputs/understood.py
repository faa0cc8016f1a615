"""How a table of a log was understood, in words, for its reader to see what was not meant."""

import re
from collections.abc import Container, Mapping
from pathlib import Path

from alloc.vehicle.geometry import DOF, MOMENTS
from bench.inputs.column_names import DURATION, may_be_meant, words_of
from bench.inputs.columns import VOLTS, Column, listed, maybe_angle, unit_of, untimed
from bench.inputs.delimited import NAMES, Cells
from bench.inputs.units import SECONDS, TIME

SHOWN = 6
"""Most columns of limits, and left out ones, that are named."""
_TIME = re.compile(r"time(?!out)|stamp|clock|zeit|(?<![a-z])(?:utc|date|datum)(?![a-z])", re.IGNORECASE)
_OF_ROWS = ("s", "sec", "ms", "msec")
"""Units that a row's time has; commands of ESCs are in µs."""


def understood(
    path: Path,
    table: Cells,
    found: Mapping[str, Column],
    limits: Mapping[str, Column],
    unit: str = "",
    blank: int = 0,
    also: Container[int | None] = (),
) -> str:
    """How a table was understood, in a line; empty where nothing had to be.

    Parameters
    ----------
    found, limits : the columns of demands and time, and those about limits
    unit : what a time was taken for, empty where the file says it
    blank : rows without a demand
    also : further columns that were taken, which are said elsewhere
    """
    named = dict(found)
    if VOLTS in limits:
        named[VOLTS] = limits[VOLTS]
    parts = [
        f"{quantity} from '{column.name}'"
        + (f" times {column.factor:g}" if quantity in DOF and column.factor != 1 and not column.unit else "")
        + (f" and '{table.header[column.rest]}'" if column.rest is not None else "")
        + (f", taken for {unit}" if quantity == TIME and unit else "")
        for quantity, column in named.items()
        if column.name != quantity
    ]
    own = [quantity for quantity, column in named.items() if column.name == quantity]
    bounds = [column.name for name, column in limits.items() if name != VOLTS]
    taken = {at for column in (*found.values(), *limits.values()) for at in (column.place, column.rest)}
    others = [
        name or "one without a name"
        for i, name in enumerate(table.header)
        if i not in taken and i not in also
    ]
    if own and (parts or limits or others):  # a column that is not named would be a guess of the reader
        parts.append(f"{', '.join(own)} by name")
    if bounds:
        parts.append(f"limits from {listed(bounds, SHOWN)}")
    if below := [f"{quantity} in {column.unit}" for quantity, column in found.items() if column.unit]:
        parts.append(f"below the header: {', '.join(below)}")
    if others:
        parts.append(f"left out: {listed(others, SHOWN)}")
    if TIME not in found and (other := untimed(table.header, table.units)):
        why = f"the unit of {other[:40]!r} is none of {', '.join(SECONDS)}"
        remedy = f"; if it has dates, --columns 't={other[:40]}'" if other in table.header else ""
        parts.append(f"no time: {why}{remedy}")
    if blank:
        parts.append(f"{blank} rows without a demand")
    if table.separator != ",":
        parts.append(NAMES[table.separator])
    if table.decimal == ",":
        parts.append("decimal commas")
    return f"{path.name}: {'; '.join(parts)}" if parts else ""


def without_time(path: Path, table: Cells, found: Mapping[str, Column]) -> str:
    """A doubt about a log without times, where a column may be these under a name that is not known."""
    if TIME in found or untimed(table.header, table.units):
        return ""
    for i, name in enumerate(table.header):
        may_be = _TIME.search(name) or unit_of(name, table.units, i) in _OF_ROWS
        if may_be and not DURATION & set(words_of(name)):
            return (
                f"{path.name}: no column is taken for times; if {name[:40]!r} has these,"
                f" --columns 't={name[:40]}', with its unit, as [ms], where the name lacks one"
            )
    return ""


def passed_over(
    path: Path, table: Cells, found: Mapping[str, Column], given: Container[str], taken: Container[int]
) -> str:
    """A doubt about bare names, as ``yaw``, beside which a column is left out that may be the demand.

    ``taken`` are the places of further columns that are taken, ``given`` the quantities that the user names.
    """
    places = {column.place for column in found.values()}
    others = [name for i, name in enumerate(table.header) if i not in places and i not in taken]
    beside = {
        axis: (column.name, other)
        for axis, column in found.items()
        if axis in DOF and axis not in given
        if (other := next((name for name in others if may_be_meant(name, column.name)), ""))
    }
    if not beside:
        return ""
    own, meant = zip(*beside.values(), strict=True)
    wanted = ",".join(map("=".join, zip(beside, meant, strict=True)))
    return (
        f"{path.name}: {listed(own, len(DOF))} taken, {listed(meant, len(DOF))} left out;"
        f" --columns '{wanted}' if that is the demand"
    )


def attitude(found: Mapping[str, Column], given: Container[str]) -> dict[str, str]:
    """By moment, the columns that are called ``yaw`` as an attitude is, where no other says a demand."""
    guessed = {axis: column for axis, column in found.items() if axis in DOF and axis not in given}
    angles = {axis: column.name for axis, column in guessed.items() if maybe_angle(column, axis)}
    said = found.keys() - angles.keys() - {TIME} - {axis for axis in MOMENTS if axis in given}
    return {} if said else angles


def like_angles(path: Path, found: Mapping[str, Column], given: Container[str]) -> str:
    """A doubt about moments that are called ``yaw``, as an attitude is, beside forces with names as ``Fx``.

    ``given`` are the quantities whose columns the user names: there is no doubt about these, but where no
    force has its axis' own name, as with X, Y and Z, moments will not have theirs either.
    """
    guessed = {axis: column for axis, column in found.items() if axis in DOF and axis not in given}
    forces = {axis: column for axis, column in found.items() if axis in DOF and axis not in MOMENTS}
    own = any(axis in words_of(column.name) for axis, column in forces.items())
    told = guessed if own else guessed | forces
    wrench = next((c.name for axis, c in told.items() if axis not in words_of(c.name)), "")
    angles = {axis: column.name for axis, column in guessed.items() if maybe_angle(column, axis)}
    if not wrench or not angles:
        return ""
    kept = ",".join(f"{axis}={name}" for axis, name in angles.items())
    return (
        f"{path.name}: {' and '.join(map(repr, angles.values()))}, beside {wrench[:40]!r}, may be attitude,"
        f" but N m are taken; --columns '{next(iter(angles))}=NAME', or --columns '{kept}' if they are"
    )
