"""Limits of each demand, from columns of a log: ``volts``, ``f0_min``, ``bow port_max`` and so on."""

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle.geometry import DOF
from alloc.vehicle.limits import VoltageTable
from bench.inputs.columns import VOLTS, Column
from bench.inputs.units import FORCE, VOLTAGE

_LIMIT = re.compile(r"f(?P<thruster>\d{1,9})_(?P<side>min|max)")
_SIDES = {"min", "max", "minimum", "maximum", "lower", "upper"}
_FORCES = {"f", "force", "thrust", "thruster", "limit", "lim"}
_MEASURED = {
    *("x", "y", "z", *DOF),
    *("depth", "temp", "temperature", "speed", "rpm", "current", "power", "voltage", "pwm", "load", "sensor"),
}
"""Words of a column that is about something else than how much a thruster may push."""
_WITH_UNIT = re.compile(
    r"(?P<name>\S.*?)\s*[\[(]\s*(?P<unit>[^\])]*?)\s*[\])]|(?P<before>.+_(?:min|max)|volts)_(?P<suffix>[a-z]+)",
    re.IGNORECASE,
)
_VOLTAGE = re.compile(
    r".*(?:[\[(]\s*m?[Vv]\s*[\])]|(?:(?<![A-Za-z])|(?<=[a-z])(?=[A-Z]))(?i:volts?|voltage|v?batt?|battery)(?:_m?[Vv])?)"
)
""" ``Battery [V]``, ``vbat``, ``bus voltage``: what may be the battery's, with its unit or by its name."""

FAR = 100.0
"""How many times the largest voltage of a table another one is before it is in doubt: mV are a thousand."""
IN_MILLIVOLTS = "if it is in mV, --columns 'volts=NAME [mV]'"


def limit_columns(
    place: str,
    header: Sequence[str],
    units: Sequence[str] = (),
    thrusters: Sequence[str] = (),
    given: Mapping[str, str] = MappingProxyType({}),
    found: Mapping[str, Column] = MappingProxyType({}),
) -> dict[str, Column]:
    """Columns that hold limits, by name: ``volts`` [V], ``f3_min`` [N].

    A column may also name one of the ``thrusters``: ``bow port_min`` is ``f0_min`` where that is the first.
    ``units`` stand in a line of their own, empty without one. ``given`` are names of columns as the user
    says them, by quantity: that of ``volts``, where it is another. What is ``found`` by such a name is no
    limit, whatever it is called.
    Raises DemandError for one twice, in another unit, or spelt like ``f_max3`` or ``Bow Port max``: limits
    that are left out give thrusts beyond them.
    """
    limits: dict[str, Column] = {}
    named = [(i, name) for i, name in enumerate(thrusters) if name]
    places = {f"{name}_{side}": f"f{i}_{side}" for i, name in named for side in ("min", "max")}
    others = {column.place for quantity, column in found.items() if quantity in given}
    for i, column in enumerate(header):
        if i in others:
            continue
        match = None if column.strip() in places else _WITH_UNIT.fullmatch(column.strip())
        said = (match["name"] or match["before"]) if match else column.strip()
        name = places.get(said) or said.lower()
        if name != VOLTS and not _LIMIT.fullmatch(name):
            # What stands behind the side may be no unit: thruster_max_temp.
            whole = match is not None and match["suffix"] not in (None, *FORCE)
            said_in = match["unit"] if match else ""
            if said_in and not said_in.isdigit() and said_in not in (*FORCE, "%"):  # of no force
                continue
            if _looks_like_a_limit(column if whole else said, thrusters):
                also = "".join(f", or {name}_min" for _, name in named[:1])
                raise DemandError(
                    f"{place}: {column[:40]!r} looks like a limit; write those as f0_min, f0_max{also}, else"
                    " rename it"
                )
            continue
        if name in limits:
            raise DemandError(f"{place}: column {name!r} appears twice; keep one")
        limits[name] = _with_factor(place, header, units, i, name)
    if volts := given.get(VOLTS, ""):
        match = _WITH_UNIT.fullmatch(volts)
        bare = match["name"] if match and match["name"] and volts not in header else volts
        if header.count(bare) != 1:
            raise DemandError(f"{place}: no column {volts[:40]!r}, or several, for volts; name one there is")
        limits[VOLTS] = _with_factor(place, header, units, header.index(bare), VOLTS, volts)
    return limits


def _with_factor(
    place: str, header: Sequence[str], units: Sequence[str], i: int, name: str, said: str = ""
) -> Column:
    """The column and its factor to V or N, by the unit in its name or in the line of units.

    ``said`` is the name with a unit as the user gives it. Raises DemandError for any other unit.
    """
    match = _WITH_UNIT.fullmatch(said or header[i].strip())
    unit = (match["unit"] or match["suffix"]) if match else units[i] if i < len(units) else ""
    if not unit and name == VOLTS and header[i].lower().endswith("_mv"):
        unit = "mV"
    known = {"": 1.0, **(VOLTAGE if name == VOLTS else {"N": 1.0})}
    factors = [factor for spelt, factor in known.items() if unit in (spelt, spelt.lower())]
    if not factors:
        raise DemandError(f"{place}: {header[i]!r} is in {unit}; give volts in V or mV, limits in N")
    return Column(i, header[i], factors[0])


def _looks_like_a_limit(name: str, thrusters: Sequence[str]) -> bool:
    """True if a name has a side, min or max, beside a thruster's name or a word for its force."""
    squeezed = _squeezed(name)
    for thruster in filter(None, map(_squeezed, thrusters)):
        if any(squeezed in (thruster + side, side + thruster) for side in _SIDES):
            return True
    words = re.findall(r"[a-z]+", re.sub(r"\bf(?=min|max)", "f ", re.sub(r"[\d_]+", " ", name.lower())))
    beside = any(_SIDES & {*pair} and _FORCES & {*pair} for pair in pairwise(words))
    beside |= any({*pair} in ({"f", "lb"}, {"f", "ub"}) for pair in pairwise(words))  # thrust_lb is in pounds
    return beside and not _MEASURED & set(words)


def _squeezed(name: str) -> str:
    return re.sub(r"[\W_]", "", name.lower())


def like_volts(header: Sequence[str]) -> str:
    """The first column that may be the battery's voltage under another name; empty where none is."""
    return next((name for name in header if _VOLTAGE.fullmatch(name.strip())), "")


def limits_in(
    path: Path, columns: Mapping[str, FloatArray], vehicle: Vehicle
) -> tuple[FloatArray, FloatArray] | tuple[None, None]:
    """f_min and f_max of each demand (N, n) [N]: the vehicle's own, cut by all that the columns say.

    (None, None) without such columns. Raises DemandError for a thruster that the vehicle does not have, for
    volts where it has no table, and for volts beyond the table; it names the file, the column and the row.
    """
    if not columns:
        return None, None
    N = len(next(iter(columns.values())))
    low, high = (np.tile(side, (N, 1)) for side in (vehicle.f_min, vehicle.f_max))
    if VOLTS in columns:
        at_least, at_most = _by_volts(path, columns[VOLTS], vehicle)
        low, high = np.maximum(low, at_least), np.minimum(high, at_most)
    for name, values in columns.items():
        if (match := _LIMIT.fullmatch(name)) is None:
            continue
        i = int(match["thruster"])
        if i >= vehicle.n:
            raise DemandError(
                f"{path}: column {name!r}: {vehicle.name} has no thruster {i}; count from 0 to"
                f" {vehicle.n - 1}"
            )
        if match["side"] == "min":
            low[:, i] = np.maximum(low[:, i], values)
        else:
            high[:, i] = np.minimum(high[:, i], values)
    off = vehicle.readiness == 0
    return np.where(off, 0.0, low), np.where(off, 0.0, high)


def _by_volts(path: Path, volts: FloatArray, vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    table: VoltageTable | None = vehicle.by_volts
    if table is None:
        raise DemandError(
            f"{path}: column 'volts': {vehicle.name} has no limits by voltage; add 'volts' to its file"
        )
    least, most = table.volts[0], table.volts[-1]
    outside = np.flatnonzero(~((volts >= least) & (volts <= most)))
    if outside.size:
        found = volts[outside[0]]
        remedy = IN_MILLIVOLTS if found > FAR * most else "cut the row out, or give more of the table"
        raise DemandError(
            f"{path}: demand {outside[0]} (counted from 0): {found:g} V lies outside of the"
            f" vehicle's table, {least:g} to {most:g} V; {remedy}"
        )
    return table.between(volts)
