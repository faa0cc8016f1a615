"""Columns of a log by quantity, from their names and units."""

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from alloc.errors import DemandError
from alloc.vehicle.geometry import DOF, MOMENTS
from bench.inputs.column_names import MEANT, SELF_UNIT, says, says_moment, words_of
from bench.inputs.units import FORCE, MOMENT, SECONDS, TIME, factor_to, known

VOLTS = "volts"
_UNIT = re.compile(r"(?P<name>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]\s*")
_SUFFIX = re.compile(rf"(?P<name>.+)_(?P<unit>{'|'.join(SECONDS)}|N|kN|Nm|kNm)")
_OTHERS = {
    *("lb", "lbs", "pound", "pounds", "kg", "kp", "gf", "gram", "grams", "tf", "tonne", "tonnes"),
    *("kilonewton", "kilonewtons", "dn", "dan", "pct", "percent", "percentage"),
    *("norm", "normalised", "normalized"),
    *("lbft", "ftlb", "ftlbs", "lbin", "inlb", "ozin", "nmm", "ncm", "kgcm", "kgm"),
    *("deg", "degs", "degree", "degrees", "rad", "rads", "radian", "radians", "us", "pwm", "rpm", "mps"),
}
"""Words that stand for another unit, a share, or no force at all, of which nothing here knows the factor."""
_WITHIN = re.compile(r"[\W_]+|(?<=[a-jln-z])(?=(?:kNm?|Nm|[lL]bf|[kK]gf)(?![A-Za-z]))")
"""What parts the words of a name: signs, and a small letter before a unit, as in ``FxkN``."""
_MOTION = re.compile(r"/|deg|°|rad|rpm|^(?:m|mm|cm|s|us|µs|pwm|mps)$", re.IGNORECASE)
"""Units of an attitude, a speed, a place or a pulse: no demand under a name that could be one."""
_UNITS = {unit.lower() for unit in (*FORCE, *MOMENT, *_OTHERS) if len(unit) > 1}
"""Words of a name that are units of a force or a moment, and not an axis, as N may be."""


class Column(NamedTuple):
    """A column of a log and what it holds.

    Attributes
    ----------
    place : which one it is, from 0
    name : its name, as the file writes it
    factor : from its unit to N, N m, V or s; None for a time whose unit nothing says
    rest : which column has the nanoseconds of a stamp whose whole seconds stand here, as ROS writes one
    unit : as a line of units below the header says it, else empty
    """

    place: int
    name: str
    factor: float | None
    rest: int | None = None
    unit: str = ""


def assign(
    place: str,
    header: Sequence[str],
    units: Sequence[str],
    dof: Sequence[str],
    given: Mapping[str, str],
    *,
    every: bool = True,
) -> dict[str, Column]:
    """The column of each DOF, and of the time where there is one.

    Parameters
    ----------
    place : file and line, for messages
    header, units : names of the columns; units from a line of their own, empty without one
    dof : what has a column
    every : whether each of ``dof`` needs one, else those are found that there are
    given : the column's name of some quantities, as the user says it

    Raises DemandError where a quantity has no column, or several could be meant.
    """
    found: dict[str, Column] = {}
    missing: list[str] = []
    for quantity in (*dof, TIME):
        if quantity in given:
            found[quantity] = _named(place, header, units, quantity, given[quantity])
            continue
        columns = [c for i in range(len(header)) if (c := _meant(header[i], units, i, quantity))]
        if every and len(columns) == 1 and maybe_angle(columns[0], quantity):
            columns += _moments(header, units, dof, given, quantity)
        exact = [column for column in columns if column.name == quantity]
        if len(columns) > 1 and quantity != TIME:
            if len(exact) > 1:
                raise DemandError(
                    f"{place}: {quantity!r} stands twice; rename one of the columns in the file"
                )
            several = " and ".join(repr(column.name[:40]) for column in columns[:3])
            raise DemandError(
                f"{place}: {quantity} may be {several}; say which, as in --columns '{quantity}=NAME'"
            )
        if columns:  # of several times the plainest: 'time' before 'imu time'
            found[quantity] = (exact or sorted(columns, key=lambda column: len(words_of(column.name))))[0]
        elif quantity != TIME and every:
            missing.append(quantity)
    if missing:
        raise DemandError(f"{place}: {_missed(header, units, missing)}")
    if TIME in found:
        found[TIME] = found[TIME]._replace(rest=_nanoseconds(header, found[TIME].name))
    return found


def _missed(header: Sequence[str], units: Sequence[str], missing: Sequence[str]) -> str:
    """The refusal of a table in which some DOF have no column, or only one in a unit that is not known."""
    shown = [f"{name} [{u}]" if (u := _below(name, units, i)) else name for i, name in enumerate(header)]
    found = {quantity: _of_unknown_unit(header, units, quantity) for quantity in missing}
    odd = {quantity: name for quantity, name in found.items() if name}
    parts = []
    if absent := [quantity for quantity in missing if quantity not in odd]:
        parts.append(
            f"no column {' or '.join(map(repr, absent))} among {listed(shown)}; name"
            f" {'them' if absent[1:] else 'it'} there, or as in"
            f" --columns {','.join(f'{quantity}=NAME' for quantity in absent)}"
        )
    if odd:
        named = [repr(shown[list(header).index(name)][:40]) for name in odd.values()]
        kinds = dict.fromkeys(
            f"{', '.join(known(q))} for a {'moment' if q in MOMENTS else 'force'}" for q in odd
        )
        taken = ",".join(f"{q}={name} [{next(iter(known(q)))}]" for q, name in odd.items())
        parts.append(
            f"the unit of {' and '.join(named)} is not known, expected {' and '.join(kinds)}; convert it in"
            f" the file, or --columns '{taken}' and --scale with how many N or N m it is"
        )
    return "; ".join(parts)


def parse_columns(text: str) -> dict[str, str]:
    """The mapping of ``--columns``: ``surge=fx,yaw=mz,t=stamp [ms],volts=battery``; raises DemandError."""
    given, quantities = {}, (*DOF, TIME, VOLTS)
    for part in re.split(rf",(?=(?:{'|'.join(quantities)})=)", text) if text else ():
        quantity, equals, name = part.partition("=")
        if not equals or quantity.strip() not in quantities or not name.strip():
            raise DemandError(
                f"--columns {text[:60]!r}: write DOF=COLUMN, t=COLUMN or volts=COLUMN, as in surge=fx,t=stamp"
            )
        given[quantity.strip()] = name.strip()
    return given


def listed(names: Sequence[str], most: int = 12) -> str:
    """The first names, in a line that any terminal can show."""
    shown = ["".join(c if c.isprintable() else repr(c)[1:-1] for c in name[:30]) for name in names[:most]]
    return ", ".join(shown) + (f" and {len(names) - most} more" if len(names) > most else "")


def maybe_angle(column: Column, quantity: str) -> bool:
    """True if nothing but a DOF's own name, as ``yaw``, makes a column a moment and no attitude."""
    return quantity in MOMENTS and words_of(column.name) == [quantity] and not column.unit


def units_said(found: Mapping[str, Column], given: Mapping[str, str], *, dates: bool) -> set[str]:
    """The quantities ``found`` whose unit the file says, as ``dates`` do, or the user in a ``given`` name."""
    said = {TIME} if dates else set[str]()
    for quantity, column in found.items():
        names = (column.name, given.get(quantity, ""))
        spelt = any(pattern.fullmatch(name) for name in names for pattern in (_UNIT, _SUFFIX))
        if spelt or column.unit or column.factor not in (None, 1.0) or column.rest is not None:
            said.add(quantity)
    return said


def _of_unknown_unit(header: Sequence[str], units: Sequence[str], quantity: str) -> str:
    """The first column that would be a DOF if its unit were known, and no motion's; empty without one."""
    for i, name in enumerate(header):
        match = _UNIT.fullmatch(name)
        bare, unit = (match["name"], match["unit"]) if match else (name, _below(name, units, i))
        if not unit and (spelt := _spelt(name, quantity)):
            bare, unit = re.sub(rf"[\W_]*(?i:{re.escape(spelt)})[\W_]*$", "", name), spelt
        if unit and says(bare, quantity) and factor_to(quantity, unit) is None and not _MOTION.search(unit):
            return name
    return ""


def untimed(header: Sequence[str], units: Sequence[str]) -> str:
    """The first column that would be the time if its unit were one, with that; empty where there is none."""
    for i, name in enumerate(header):
        match = _UNIT.fullmatch(name)
        unit = unit_of(name, units, i)
        if unit and says(match["name"] if match else name, TIME) and factor_to(TIME, unit) is None:
            return name if match else f"{name} [{unit}]"
    return ""


def _nanoseconds(header: Sequence[str], name: str) -> int | None:
    """The column beside that of a stamp's whole seconds: stamp.sec and stamp.nanosec, secs and nsecs."""
    whole = re.fullmatch(r"(.*?)secs?", name, re.IGNORECASE)
    beside = {whole[1].lower() + word for word in ("nanosec", "nsec", "nanosecs", "nsecs")} if whole else ()
    return next((i for i, other in enumerate(header) if other.lower() in beside), None)


def _named(place: str, header: Sequence[str], units: Sequence[str], quantity: str, wanted: str) -> Column:
    """The column that --columns names, by its whole name, or by the part before a unit that is said here."""
    bare = _UNIT.fullmatch(wanted)
    if header.count(wanted) > 1:
        raise DemandError(f"{place}: {wanted[:40]!r} stands twice; rename one of the columns in the file")
    for i, name in enumerate(header):
        below = ""
        if name == wanted:
            unit, below = unit_of(name, units, i) or _spelt(name, quantity), _below(name, units, i)
            factor = factor_to(quantity, unit)
            if quantity == TIME:
                factor = factor or SELF_UNIT.get(name.lower())
        elif bare and name == bare["name"]:
            factor = factor_to(quantity, bare["unit"])
        else:
            continue
        if factor is None and (quantity != TIME or name != wanted):
            other = "and of another unit with --scale how many of these it is"
            if quantity == TIME:
                other = "and none where there are dates"
            raise DemandError(
                f"{place}: the unit of {wanted[:40]!r} is none of {', '.join(known(quantity))}; say which it"
                f" is, as in --columns '{quantity}=NAME [{next(iter(known(quantity)))}]', {other}"
            )
        return Column(i, name, factor, unit=below)
    raise DemandError(
        f"{place}: no column {wanted[:40]!r} for {quantity}; there are {', '.join(header)[:200]}"
    )


def _meant(name: str, units: Sequence[str], index: int, quantity: str) -> Column | None:
    """A column whose name and unit say the quantity; None for any other."""
    for pattern in (_UNIT, _SUFFIX):
        match = pattern.fullmatch(name)
        if match and says(match["name"], quantity):
            factor = factor_to(quantity, match["unit"])
            return None if factor is None else Column(index, name, factor)
    if not says(name, quantity):
        return None
    unit = unit_of(name, units, index)
    factor = factor_to(quantity, unit)
    if quantity == TIME and not unit:
        return Column(index, name, SELF_UNIT.get(name.lower(), 1.0 if name == TIME else None))
    return None if factor is None else Column(index, name, factor, unit=_below(name, units, index))


def _moments(
    header: Sequence[str], units: Sequence[str], dof: Sequence[str], given: Mapping[str, str], quantity: str
) -> list[Column]:
    """Columns that may be a moment by a name or unit that no other quantity has."""
    found = []
    for i, name in enumerate(header):
        match = _UNIT.fullmatch(name) or _SUFFIX.fullmatch(name)
        bare, unit = (match["name"], match["unit"]) if match else (name, _below(name, units, i))
        free = name not in given.values() and not any(_meant(name, units, i, axis) for axis in dof)
        if free and says_moment(bare, quantity) and factor_to(quantity, unit) is not None:
            found.append(Column(i, name, None))
    return found


def _spelt(name: str, quantity: str) -> str:
    """The unit that stands in a name without brackets, known or not, as in ``Fx_lbf``; empty for none."""
    if "%" in name:
        return "%"
    first, *words = [word for word in _WITHIN.split(name) if word] or [""]
    while words and words[-1].lower() in MEANT:
        words.pop()
    last = words[-2:]
    if quantity != TIME:  # kN_Fx, but N is an axis
        words = [*([first] if len(first) > 1 else []), *words]
    for word in ("".join(last), *reversed(last if quantity == TIME else words)):
        alike = [unit for unit in known(quantity) if unit.lower() == word.lower()]
        if word in alike or (len(alike) == 1 and len(word) > 1):
            return word if word in alike else alike[0]
        if quantity != TIME and word.lower() in _UNITS:
            return word
    return ""


def unit_of(name: str, units: Sequence[str], index: int) -> str:
    """The unit of a column, in brackets behind its name or on a line below; empty where there is none."""
    match = _UNIT.fullmatch(name)
    return match["unit"] if match else _below(name, units, index)


def _below(name: str, units: Sequence[str], index: int) -> str:
    """The unit on a line below the header of a column whose name has none."""
    return "" if _UNIT.fullmatch(name) or index >= len(units) else units[index]
