"""Columns of a log by quantity: the known headers as a table, and names and units from the user."""

import re
from collections.abc import Iterable, Mapping, Sequence
from math import isnan, nan
from operator import itemgetter
from shlex import quote
from typing import NamedTuple
from unicodedata import normalize

from alloc.errors import DemandError
from alloc.vehicle.geometry import DOF, MOMENTS

TIME, VOLTS = "t", "volts"
FORCE = {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "lbf": 4.4482216152605, "kgf": 9.80665}
MOMENT = {
    "Nm": 1.0,
    "kNm": 1e3,
    "MNm": 1e6,
    "mNm": 1e-3,
    "kgfm": 9.80665,
    **dict.fromkeys(("lbfft", "ftlbf"), 4.4482216152605 * 0.3048),
}
SECONDS = {
    **dict.fromkeys(("s", "sec"), 1.0),
    **dict.fromkeys(("ms", "msec"), 1e-3),
    **dict.fromkeys(("us", "usec", "\u03bcs"), 1e-6),  # NFKC turns the micro sign into this Greek letter
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}
VOLTAGE = {"V": 1.0, "mV": 1e-3}
UNITS = {*FORCE, *MOMENT, *SECONDS, "N m", "N·m", "N*m", "µs", "%"}
"""Units of which a line below the header holds at least one."""


class Wrench(NamedTuple):
    """One spelling of the six columns of a wrench.

    Attributes
    ----------
    names : of surge to yaw in small letters, parts joined by dots; empty where there is none
    frame : frd or flu, of the axes that such names mean; empty for the vehicle's own
    source : who writes such names; empty for many
    shares : whether 1 is all that the vehicle can do on an axis, not 1 N or 1 N m
    """

    names: tuple[str, ...]
    frame: str = ""
    source: str = ""
    shares: bool = False


_ROS = tuple(f"{part}.{axis}" for part in ("force", "torque") for axis in "xyz")
_PX4 = tuple(f"vehicle.{part}.setpoint.xyz[{i}]" for part in ("thrust", "torque") for i in range(3))
WRENCHES = (
    Wrench(DOF),
    Wrench(("fx", "fy", "fz", "mx", "my", "mz")),
    Wrench(("force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z")),
    *(Wrench(tuple(f"{axis}.{end}" for axis in DOF)) for end in ("cmd", "des", "ref", "demand", "setpoint")),
    *(Wrench(tuple(f"{start}.{axis}" for axis in DOF)) for start in ("cmd", "des", "ref", "demand", "tau")),
    *(Wrench(tuple(start + n for n in _ROS), "flu", "ROS") for start in ("", "wrench.", "field.wrench.")),
    Wrench(_PX4, "frd", "PX4", shares=True),
    Wrench(("", "", "", "rout", "pout", "yout"), "frd", "ArduPilot", shares=True),
)
"""Known names of a wrench's columns, in N and N m without another unit; those of a log are one row."""
TIMES = {"t": "s", "seconds": "s", "field.header.stamp": "ns", "rosbagtimestamp": "ns"}
TIMES |= {"timeus": "us", "timems": "ms", "millis": "ms", "micros": "us"}
TIMES |= dict.fromkeys(("header.stamp", "stamp", "timestamp", "time", "elapsed", "time.boot", "time.utc"), "")
"""Known names of times, the preferred first, and their unit; empty where a log must state it."""
STAMPS = {".sec": ".nanosec", ".secs": ".nsecs"}
"""Ends of the names of the two columns of a ROS stamp: whole seconds, and the nanoseconds beyond."""
FRAMES = ("frame", "frame.id", "header.frame.id", "field.header.frame.id")
"""Known names of the column of the frame."""
_BRACKETS = re.compile(r"(?P<name>.*?)\s*[\[(](?P<unit>(?!\d+[\])])[^\])]*)[\])]\s*")
_SUFFIX = re.compile(r"(?P<name>.+)_(?P<unit>s|sec|m?s|msec|us|usec|ns|k?Nm?|m?V)")
_AXES = {name: axis for wrench in WRENCHES for name, axis in zip(wrench.names, DOF, strict=True) if name}
_ANGLES = {name for name in _AXES if {*MOMENTS} & {*name.split(".")} and not name.startswith("tau.")}
"""Known names of moments that attitudes have as well, as ``yaw`` and ``yaw.cmd``."""


class TableHeader(NamedTuple):
    """The header of a table.

    Attributes
    ----------
    place : file and line, for messages
    names, units : of the columns; units are those of a line of their own, empty without one
    """

    place: str
    names: Sequence[str]
    units: Sequence[str]


class Column(NamedTuple):
    """A column of a log and what it holds.

    Attributes
    ----------
    place : which one it is, from 0
    name : as the file writes it
    factor : from its unit to N, N m, V or s; NaN where nothing states one that is known
    unit : as the file or the user states it, else empty
    rest : which column has the nanoseconds of a stamp whose whole seconds stand here, as ROS writes one
    """

    place: int
    name: str
    factor: float
    unit: str = ""
    rest: int | None = None


def key(name: str) -> str:
    """The form in which known names stand: small letters, and dots for whatever parts a path."""
    return re.sub(r"[./_ ]+", ".", name.strip().lower()).strip(".")


def split(name: str, below: str = "") -> tuple[str, str]:
    """A header's name and its unit: in brackets, behind an underscore, or ``below`` the name; else empty."""
    match = _BRACKETS.fullmatch(name) or _SUFFIX.fullmatch(name)
    return (match["name"], match["unit"]) if match else (name, below)


def known_units(quantity: str) -> dict[str, float]:
    """The units of a time, a voltage or a DOF, and what each is in s, V, N or N m."""
    others = {TIME: SECONDS, VOLTS: VOLTAGE}
    return others.get(quantity, MOMENT if quantity in MOMENTS else FORCE)


def unit_factor(quantity: str, unit: str) -> float:
    """From a unit to that of the quantity; NaN for any other unit."""
    return known_units(quantity).get(normalize("NFKC", re.sub(r"[\s·*.-]", "", unit)), nan)


def find_spellings(names: Iterable[str]) -> set[Wrench]:
    """The spellings that all of some names can be out of; empty where there is none."""
    keys = {key(name) if key(name) in _AXES else key(split(name)[0]) for name in names}
    return {wrench for wrench in WRENCHES if keys and keys <= set(wrench.names)}


def assign(
    header: TableHeader, dof: Sequence[str], given: Mapping[str, str], *, every: bool = True
) -> dict[str, Column]:
    """The column of each DOF, and of the time where there is one.

    Parameters
    ----------
    dof : what has a column
    given : the column's name of some quantities, as the user states it
    every : whether each of ``dof`` needs one, else those are found that there are

    Raises DemandError, with the option --columns that settles it, where a DOF has no column, or may have
    several, or columns are of two spellings, or a unit is not stated, or not known.
    """
    place, known = header.place, _known(header)
    found = {q: named_column(header, q, given) for q in (*dof, TIME) if q in given}
    usable = {
        axis: [column for column in known.get(axis, []) if not isnan(column.factor)]
        for axis in dof
        if axis not in given
    }
    if several := {axis: columns for axis, columns in usable.items() if len(columns) > 1}:
        raise DemandError(f"{place}: {_contested(several, given)}")
    by_table = {axis: columns[0] for axis, columns in usable.items() if columns}
    if every and (missing := [axis for axis in dof if axis not in found and axis not in by_table]):
        raise DemandError(f"{place}: {_missed(header, known, given, missing)}")
    if by_table and not find_spellings(column.name for column in by_table.values()):
        names = listed([column.name for column in by_table.values()])
        named = {**given, **{axis: column.name for axis, column in by_table.items()}}
        raise DemandError(
            f"{place}: {names} are of two spellings, expected one, as yaw beside Fx may be an angle;"
            f" if they are the demand, {columns_option(named)}"
        )
    if any(axis in given for axis in dof if axis not in MOMENTS) and (angles := possible_angles(by_table)):
        raise DemandError(
            f"{place}: {listed([*angles.values()])} may be an attitude, as no force has a known name;"
            f" if they are the demand, {columns_option({**given, **angles})}"
        )
    found |= by_table
    places = [column.place for column in found.values()]
    if twice := [q for q, column in found.items() if places.count(column.place) > 1]:
        name = found[twice[0]].name[:40]
        raise DemandError(
            f"{place}: column {name!r} is {listed(twice)}, expected one of them; name another by"
            f" {columns_option({**given, twice[-1]: 'NAME'})}"
        )
    if TIME not in given and (stamps := known.get(TIME, []) + _two_columns(header.names)):
        other = [column for column in stamps if isnan(column.factor) and column.unit]  # as T [C]
        found[TIME] = next((column for column in stamps if column not in other), stamps[0])
    return found


def _contested(several: Mapping[str, Sequence[Column]], given: Mapping[str, str]) -> str:
    """The refusal of a table in which each axis may be any of several columns."""
    may = "; ".join(
        f"{axis} may be {' or '.join(repr(column.name[:40]) for column in columns)}"
        for axis, columns in several.items()
    )
    if any(len({column.name for column in columns}) < len(columns) for columns in several.values()):
        return f"{may}; rename one"
    first, last = (
        columns_option({**given, **{axis: columns[end].name for axis, columns in several.items()}})
        for end in (0, -1)
    )
    return f"{may}; choose by {first} or {last}"


def possible_angles(found: Mapping[str, Column]) -> dict[str, str]:
    """By axis, names of moments without a unit that may be an attitude; none beside a force."""
    columns = {axis: c.name for axis, c in found.items() if not c.unit and key(c.name) in _ANGLES}
    return columns if {*found} <= {*MOMENTS} else {}


def _known(header: TableHeader) -> dict[str, list[Column]]:
    """The columns with known names, by quantity; of times the preferred first."""
    found: dict[str, list[tuple[int, Column]]] = {}
    order = list(TIMES)
    for i, (name, below) in enumerate(zip(header.names, header.units, strict=True)):
        is_whole = key(name) in _AXES or key(name) in TIMES  # its last part is no unit
        bare, unit = (name, below) if is_whole else split(name, below)
        quantity = _AXES.get(key(bare)) or (TIME if key(bare) in TIMES else "")
        if quantity:
            usual = TIMES[key(bare)] if quantity == TIME else next(iter(known_units(quantity)))
            rank = order.index(key(bare)) if quantity == TIME else 0
            column = Column(i, name, unit_factor(quantity, unit or usual), unit)
            found.setdefault(quantity, []).append((rank, column))
    return {q: [column for _, column in sorted(ranked, key=itemgetter(0))] for q, ranked in found.items()}


def _two_columns(header: Sequence[str]) -> list[Column]:
    """Times of ROS stamps in two columns, as ``stamp.sec`` and ``stamp.nanosec``."""
    keys = [f".{key(name)}" for name in header]
    return [
        Column(i, header[i], 1.0, rest=keys.index(name.removesuffix(end) + behind))
        for i, name in enumerate(keys)
        for end, behind in STAMPS.items()
        if name.endswith(end) and name.removesuffix(end) + behind in keys
    ]


def named_column(header: TableHeader, quantity: str, given: Mapping[str, str]) -> Column:
    """The column that --columns gives a quantity, by its whole name, or by that with a unit behind it."""
    (place, names, units), wanted = header, given[quantity]
    match = _BRACKETS.fullmatch(wanted)
    name, unit = (match["name"], match["unit"]) if match and wanted not in names else (wanted, "")
    if names.count(name) != 1:
        got = f"stands {names.count(name)} times" if name in names else "is not there"
        raise DemandError(f"{place}: column {name[:40]!r} for {quantity} {got}; there are {listed(names)}")
    i = names.index(name)
    alike = [q for q in (*DOF, TIME) if known_units(q) is known_units(quantity) and not unit]
    own = _known(TableHeader(place, [name], [units[i]]))
    usual = [column.factor for q, columns in own.items() for column in columns if q in alike]
    usual += [1.0] if quantity == name.lower() == VOLTS and not (unit or units[i]) else []
    unit = unit or split(name, units[i])[1]
    column = Column(i, name, usual[0] if usual else unit_factor(quantity, unit), unit)
    if isnan(column.factor) and quantity != TIME:  # dates have no unit
        got = f"unit {unit[:40]!r}" if unit else "no unit"
        unit_added = propose_column(quantity, name)
        raise DemandError(
            f"{place}: column {name[:40]!r} for {quantity} has {got}, expected one of"
            f" {', '.join(known_units(quantity))}; {columns_option({**given, quantity: unit_added})}"
            f"{', and --scale for any other' if quantity in DOF else ''}"
        )
    return column


def propose_column(quantity: str, name: str) -> str:
    """A column's name with the first unit of the quantity, for --columns."""
    return f"{name} [{next(iter(known_units(quantity)))}]"


def _missed(
    header: TableHeader,
    known: Mapping[str, Sequence[Column]],
    given: Mapping[str, str],
    missing: Sequence[str],
) -> str:
    """The refusal of a table in which some DOF have no column, or only one in a unit that is not known."""
    shown = [
        f"{name} [{unit}]" if unit and not _BRACKETS.fullmatch(name) else name
        for name, unit in zip(header.names, header.units, strict=True)
    ]
    odd = {axis: known[axis][0] for axis in missing if axis in known}
    parts = []
    if absent := [axis for axis in missing if axis not in odd]:
        parts.append(f"no column {' or '.join(map(repr, absent))} among {listed(shown)}")
    if odd:
        names = " and ".join(repr(shown[column.place][:40]) for column in odd.values())
        kinds = " or ".join(dict.fromkeys(", ".join(known_units(axis)) for axis in odd))
        parts.append(f"the unit of {names} is not known, expected {kinds}; convert it in the file")
    named = {axis: propose_column(axis, odd[axis].name if axis in odd else "NAME") for axis in missing}
    return f"{'; '.join(parts)}; {columns_option({**given, **named})}{' and --scale' if odd else ''}"


def columns_option(named: Mapping[str, str]) -> str:
    """The option --columns that names these columns, to be pasted into a shell."""
    text = ",".join(f"{quantity}={name}" for quantity, name in named.items())
    return "--columns " + (quote(text) if "'" in text else f"'{text}'")


def parse_columns(text: str) -> dict[str, str]:
    """The mapping of ``--columns``: ``surge=fx,t=stamp [ms],volts=battery [V]``; raises DemandError."""
    given, quantities = {}, (*DOF, TIME, VOLTS)
    for part in re.split(rf",(?=(?:{'|'.join(quantities)})=)", text) if text else ():
        quantity, equals, name = part.partition("=")
        if not equals or quantity.strip() not in quantities or not name.strip():
            raise DemandError(
                f"--columns {text[:60]!r}: expected DOF=COLUMN, t=COLUMN or volts=COLUMN, as in"
                " 'surge=fx,t=stamp [ms]'"
            )
        given[quantity.strip()] = name.strip()
    return given


def listed(names: Sequence[str], most: int = 12) -> str:
    """The first names, in a line that any terminal can show."""
    shown = ["".join(c if c.isprintable() else repr(c)[1:-1] for c in name[:30]) for name in names[:most]]
    return ", ".join(shown) + (f" and {len(names) - most} more" if len(names) > most else "")


def describe_columns(
    file: str,
    header: Sequence[str],
    found: Mapping[str, Column],
    limits: Mapping[str, Column],
    also: Iterable[int] = (),
) -> str:
    """A line on which columns are used and left out; empty for ours alone. ``also`` are places in use too."""
    named = {**found, **{name: column for name, column in limits.items() if name == VOLTS}}
    parts, own = [], []
    for quantity, column in named.items():
        if column.name == quantity and not column.unit:
            own.append(quantity)
            continue
        usual = TIMES.get(key(column.name), "") or next(iter(known_units(quantity)))
        known = not (isnan(column.factor) or column.rest is not None)
        shares = any(wrench.shares for wrench in find_spellings([column.name]))
        unit = column.unit or (usual if known and not shares else "")
        rest = f" and '{header[column.rest]}'" if column.rest is not None else ""
        stated = f" [{unit}]" if unit and split(column.name)[1] != unit else ""
        parts.append(f"{quantity} from '{column.name}'{rest}{stated}")
    bounds = [column.name for name, column in limits.items() if name != VOLTS]
    used = {place for column in (*found.values(), *limits.values()) for place in (column.place, column.rest)}
    used |= {*also}
    others = [name or "one without a name" for i, name in enumerate(header) if i not in used]
    parts += [f"{', '.join(own)} by name"] if own and (parts or limits or others) else []
    parts += [f"limits from {listed(bounds, 6)}"] if bounds else []
    parts += [f"left out: {listed(others, 6)}"] if others else []
    parts += ["no times without --columns 't=NAME [s]'"] if others and TIME not in found else []
    return f"{file}: {'; '.join(parts)}" if parts else ""
