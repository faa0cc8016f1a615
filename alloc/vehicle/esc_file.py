"""The ESCs that the key ``esc`` of a vehicle file describes, and their measured curves."""

from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import FileError, VehicleError
from alloc.files.textfile import read_text
from alloc.vehicle.esc import Esc
from alloc.vehicle.keys import EscKeys, Points
from alloc.vehicle.limits import VoltageTable
from alloc.vehicle.names import listed

GRAVITY = 9.80665
"""Newtons of a kilogram-force."""
LARGEST_COMMAND = 1e6
MOST_POINTS = 20_000
SHORT = 0.05
"""Share of a span of commands by which a curve may end early at either end [-]: the last two points, where a
sweep over 800 us takes steps of 20. The shipped table leaves out none at any voltage."""
COLUMNS = {
    "command": ("command", "pwm", "pwm (µs)", "pwm (us)", "pulse", "throttle"),
    "N": ("n", "force (n)", "thrust (n)", "f [n]", "force [n]", "thrust [n]"),
    "kgf": ("kgf", "force (kg f)", "force (kgf)", "thrust (kgf)", "force [kgf]", "thrust [kgf]"),
    "volts": ("volts", "voltage", "voltage (v)", "volts [v]"),
    "amps": ("amps", "current", "current (a)", "amps [a]", "current [a]"),
}
"""Names that a column of a curve may have, in small letters; makers' own headers among them."""

OTHER_MARKS = {";": "semicolons", "\t": "tabs"}
"""Other separators of a table's cells, which are not read here."""


class ThrustCurve(NamedTuple):
    """A measured curve as its file has it.

    Attributes
    ----------
    volts : (m,) rising [V]; (1,) NaN where the file does not say
    points : commands and thrusts [N] at each of them, (p, 2), commands rising
    """

    volts: FloatArray
    points: tuple[FloatArray, ...]


def measured(keys: EscKeys, key: str = "esc") -> ThrustCurve | None:
    """The points of the file's curve as they were measured; None without one. Raises VehicleError."""
    if keys.curve is None:
        return None
    by_volts = read_curve(shipped_curve(keys.curve, key)) if isinstance(keys.curve, str) else keys.curve
    return by_voltage(by_volts, keys.volts, f"{key}.curve", "N")


def by_voltage(by_volts: Points, usual: float | None, key: str, unit: str) -> ThrustCurve:
    """Points [command, unit] of a file, sorted; ``usual`` [V] is of a table without. Raises VehicleError."""
    # Single points at several voltages are one sweep under a battery that sags, which `escs` says of them.
    fewest = 2 if len(by_volts) == 1 else 1
    owner = key.partition(".")[0]
    at: list[tuple[float, FloatArray]] = []
    for text, points in by_volts.items():
        try:
            volts = float(text) if text else (np.nan if usual is None else usual)
        except ValueError:
            volts = -1.0
        if not (np.isnan(volts) or 0 < volts < LARGEST_COMMAND):
            raise VehicleError(f"{key}: {text[:40]!r} is no voltage; give a number of volts", owner)
        array = np.array(sorted(points), dtype=np.float64).reshape(-1, 2)
        if len(array) < fewest or not (np.abs(array) <= LARGEST_COMMAND).all():
            raise VehicleError(
                f"{key}: at {text or 'no'} V give two or more pairs [command, {unit}], none beyond"
                f" {LARGEST_COMMAND:g}",
                owner,
            )
        if not (np.diff(array[:, 0]) > 0).all():
            twice = array[np.flatnonzero(np.diff(array[:, 0]) == 0)[0], 0]
            raise VehicleError(
                f"{key}: command {twice:g} stands twice at {text or 'no'} V; keep one, or their mean", owner
            )
        at.append((volts, array))
    at.sort(key=lambda entry: entry[0])
    found = np.array([volts for volts, _ in at])
    if not at or (len(at) > 1 and not (np.diff(found) > 0).all()):
        raise VehicleError(f"{key}: give different voltages, each with its pairs [command, {unit}]", owner)
    return ThrustCurve(found, tuple(points for _, points in at))


def monotone(points: FloatArray, neutral: float) -> FloatArray:
    """Thrusts (p,) that never fall with the command, 0 on the wrong side of neutral [N].

    They are the nearest in the sum of squares to those of ``points`` (p, 2).
    """
    command, f = points.T
    rising = sided(command, f, neutral)
    if (np.diff(rising) >= 0).all():
        return rising
    from scipy.optimize import isotonic_regression

    nearest: FloatArray = isotonic_regression(rising).x
    return nearest


def shipped_curves() -> tuple[str, ...]:
    """Names of the shipped curves, sorted."""
    folder = resources.files("alloc") / "vehicles"
    return tuple(sorted(f.name.removesuffix(".csv") for f in folder.iterdir() if f.name.endswith(".csv")))


def shipped_curve(name: str, key: str = "esc") -> Path:
    """The CSV of the shipped curve of that name; raises VehicleError."""
    table = resources.files("alloc") / "vehicles" / f"{name}.csv"
    if "/" in name or not table.is_file():
        raise VehicleError(
            f"{key}.curve: {name[:60]!r} is no shipped curve and no CSV; there are"
            f" {', '.join(shipped_curves())}",
            key,
        )
    return Path(str(table))


def read_curve(path: Path) -> Points:
    """The points of a CSV with columns command, N or kgf, and volts, by voltage ("" without that column).

    Lines that begin with ``#`` are comments; further columns are left out. Raises FileError.
    """
    return read_columns(path)[0]


def read_columns(path: Path) -> tuple[Points, Points]:
    """The points [command, N] of a CSV, and those [command, A] of rows that have a number in a column amps.

    Otherwise as ``read_curve``.
    """
    rows = [
        (line, [cell.strip() for cell in text.split(",")])
        for line, text in enumerate(read_text(path, 1_000_000).splitlines(), start=1)
        if text.strip() and not text.lstrip().startswith("#")
    ]
    if not rows:
        raise FileError("holds no curve; give columns command, N or kgf, volts", path=path)
    (line, header), *rest = rows
    places = {
        kind: [i for i, cell in enumerate(header) if cell.lower() in names] for kind, names in COLUMNS.items()
    }
    force = "kgf" if places["kgf"] else "N"
    if len(places["command"]) != 1 or len(places["N"]) + len(places["kgf"]) != 1 or len(places["volts"]) > 1:
        mark = next((f", with {words}" for mark, words in OTHER_MARKS.items() if mark in header[0]), "")
        raise FileError(
            f"the header has {', '.join(header)[:60]!r}{mark}; give columns command, N or kgf (one of them),"
            " volts, with commas between cells and decimal points",
            path=path,
            line=line,
        )
    if len(rest) > MOST_POINTS:
        raise FileError(f"has more than {MOST_POINTS} rows; thin it out", path=path)
    found: Points = {}
    currents: Points = {}
    amps = next(iter(places["amps"]), None)
    for line, cells in rest:
        if any(cell.strip().isdigit() for cell in cells[len(header) :]):  # 1100,-3,5 below command,N
            raise FileError(
                f"{len(cells)} cells under {len(header)} columns; give one a column, with decimal points",
                path=path,
                line=line,
            )
        try:
            command, value = (float(cells[places[kind][0]]) for kind in ("command", force))
            volts = f"{float(cells[places['volts'][0]]):g}" if places["volts"] else ""
            current = None if amps is None or not cells[amps] else float(cells[amps])
        except (ValueError, IndexError):
            raise FileError("a number is missing or is none; mend that row", path=path, line=line) from None
        if not np.isfinite([command, value, current or 0.0]).all():
            raise FileError("holds NaN or infinity; mend that row", path=path, line=line)
        found.setdefault(volts, []).append((command, value * (GRAVITY if force == "kgf" else 1.0)))
        if current is not None:
            currents.setdefault(volts, []).append((command, current))
    return found, currents


def with_curve_read(keys: EscKeys, folder: Path) -> EscKeys:
    """The keys with what a curve's CSV holds, whose path starts at ``folder``; raises FileError."""
    if not isinstance(keys.curve, str) or keys.curve in shipped_curves():
        return keys
    curve, currents = read_columns(folder / keys.curve)
    return msgspec.structs.replace(keys, curve=curve, current=keys.current or dict(currents) or None)


def sided(command: FloatArray, f: FloatArray, neutral: float) -> FloatArray:
    """f without what lies on the wrong side of neutral: none above 0 below it, none below 0 above it."""
    return np.clip(f, np.where(command < neutral, -np.inf, 0.0), np.where(command > neutral, np.inf, 0.0))


FEWEST_STEPS = 20
"""Fewest steps of 1 in a range that says nothing of its step: a share of -1 … 1 has two, by mistake."""


def escs(
    keys: EscKeys | Sequence[EscKeys],
    n: int,
    names: Sequence[str],
    f_min: FloatArray | None,
    f_max: FloatArray | None,
) -> tuple[Esc, ...]:
    """The ESC of each of n thrusters; those that are alike share one. Raises VehicleError.

    ``f_min`` and ``f_max`` (n,) [N] are what a file says, for an ESC without a curve.
    """
    if isinstance(keys, EscKeys):
        turned = _turned(keys, n, names, "esc")
        pair = {
            (way, limits): _esc(keys, way, limits, "esc")
            for way, limits in {(turned[i], _limits(keys, i, f_min, f_max)) for i in range(n)}
        }
        return tuple(pair[turned[i], _limits(keys, i, f_min, f_max)] for i in range(n))
    if len(keys) != n:
        raise VehicleError(f"esc: {len(keys)} entries for {n} thrusters; give one, or one each", "esc")
    ways = [_turned(one, n, names, f"esc[{i}]") for i, one in enumerate(keys)]
    for i, (one, way) in enumerate(zip(keys, ways, strict=True)):
        others = [] if isinstance(one.reversed, bool) else [j for j in range(n) if way[j] and not ways[j][j]]
        if others:  # one entry says nothing of another's thruster
            raise VehicleError(
                f"esc[{i}].reversed: names thruster {others[0]}, whose own entry is esc[{others[0]}]; write"
                " 'reversed: true' there",
                f"esc[{i}]",
            )
    return tuple(
        _esc(one, ways[i][i], _limits(one, i, f_min, f_max), f"esc[{i}]") for i, one in enumerate(keys)
    )


def curve_limits(made: Sequence[Esc]) -> tuple[FloatArray, FloatArray]:
    """f_min and f_max (n,) at the ends of the curves at their nominal voltages [N]; raises VehicleError."""
    spans = []
    for esc in made:
        if esc.needs_volts:
            raise VehicleError(
                "esc.volts: the curve has several voltages, so f_min and f_max need one; give 'volts' in"
                " 'esc', or f_min and f_max",
                "esc",
            )
        at = esc.volts[:1] if np.isnan(esc.nominal) else np.array([esc.nominal])
        spans.append([side[0] for side in esc.span(at)])
    low, high = np.array(spans).T
    return low, high


def voltage_table(made: Sequence[Esc]) -> VoltageTable | None:
    """Limits by voltage at the ends of the curves; None where one of them has fewer than two voltages."""
    if any(len(esc.volts) < 2 for esc in made):
        return None
    volts = np.unique(np.concatenate([esc.volts for esc in made]))
    least, most = max(esc.volts[0] for esc in made), min(esc.volts[-1] for esc in made)
    volts = volts[(volts >= least) & (volts <= most)]
    if len(volts) < 2:
        return None
    sides = [np.column_stack(side) for side in zip(*(esc.span(volts) for esc in made), strict=True)]
    return VoltageTable(volts, sides[0], sides[1])


def _turned(keys: EscKeys, n: int, names: Sequence[str], key: str) -> list[bool]:
    if isinstance(keys.reversed, bool):
        return [keys.reversed] * n
    turned = listed(keys.reversed, names, n, f"{key}.reversed", key)
    return [i in turned for i in range(n)]


def _limits(
    keys: EscKeys, i: int, f_min: FloatArray | None, f_max: FloatArray | None
) -> tuple[float, float] | None:
    if keys.curve is not None:
        return None
    if f_min is None or f_max is None:
        raise VehicleError("esc: without a curve thrust is linear up to f_min and f_max; give both", "esc")
    if i >= min(len(f_min), len(f_max)):
        raise VehicleError(f"f_min: {len(f_min)} limits, {len(f_max)} of f_max; give one each", "f_min")
    return float(f_min[i]), float(f_max[i])


def _esc(keys: EscKeys, turned: bool, limits: tuple[float, float] | None, key: str) -> Esc:
    neutral, (low, high) = keys.neutral, keys.range
    if not -LARGEST_COMMAND <= low < high <= LARGEST_COMMAND:
        raise VehicleError(f"{key}.range: give the least and the largest command, the least first", key)
    if not low <= neutral <= high:
        raise VehicleError(
            f"{key}.neutral: {neutral:g} lies outside of the range {low:g} … {high:g}; mend one of them", key
        )
    if keys.step is None and high - low < FEWEST_STEPS:
        raise VehicleError(
            f"{key}.step: the range {low:g} … {high:g} has no room for steps of 1; give what the wire"
            f" resolves, as in step: {(high - low) / 1000:g}",
            key,
        )
    step = 1.0 if keys.step is None else keys.step
    if not 0 < step <= high - low:
        raise VehicleError(
            f"{key}.step: {step:g} is no step in {low:g} … {high:g}; give more than 0 and less", key
        )
    if keys.volts is not None and not 0 < keys.volts < LARGEST_COMMAND:
        raise VehicleError(f"{key}.volts: {keys.volts:g} is no voltage; give a number of volts", key)
    # As if not reversed: what stands on the wire is mirrored at the very end.
    first, last = (2 * neutral - high, 2 * neutral - low) if turned else (low, high)
    if limits is not None:
        ends = np.array([[first, min(limits[0], 0.0)], [neutral, 0.0], [last, max(limits[1], 0.0)]])
        curve = ThrustCurve(np.array([np.nan]), (ends[[first < neutral, True, last > neutral]],))
    else:
        curve = measured(keys, key) or ThrustCurve(np.array([np.nan]), ())
    inside = [points[(points[:, 0] > first) & (points[:, 0] < last)] for points in curve.points]
    start, stop = _shared(curve, first, last, key)
    if not start <= neutral <= stop or start == stop:
        raise VehicleError(
            f"{key}.curve: its commands {start:g} … {stop:g} within the range leave out neutral,"
            f" {neutral:g}; give points on both sides of it",
            key,
        )
    command = np.unique(np.concatenate([[start, neutral, stop], *(points[:, 0] for points in inside)]))
    command = command[(command >= start) & (command <= stop)]
    f = np.array([_resampled(points, neutral, command) for points in curve.points])
    if not np.abs(f).max(axis=1).all():
        raise VehicleError(
            f"{key}.curve: thrust never rises with the command; if the ESC runs the other way, say so in"
            " 'reversed', and give the curve as if it did not",
            key,
        )
    nominal = np.nan if keys.volts is None else keys.volts
    for array in (curve.volts, command, f):
        array.setflags(write=False)
    return Esc(
        neutral, low, high, step, keys.dead_band == "jump", turned, curve.volts, command, f, float(nominal)
    )


def _shared(curve: ThrustCurve, first: float, last: float, key: str) -> tuple[float, float]:
    """The commands within first … last that the curve has at every voltage; raises VehicleError.

    A battery sags under load, so the volts logged along one sweep cut it in pieces by how much it pulled.
    What they share is the gentlest commands alone, so a voltage without about all commands is refused.
    """
    lows, highs = np.clip([points[[0, -1], 0] for points in curve.points], first, last).T
    least, most = lows.min(), highs.max()
    short = np.maximum(lows - least, most - highs)
    i = int(short.argmax())
    if short[i] > SHORT * (most - least):
        raise VehicleError(
            f"{key}.curve: at {curve.volts[i]:g} V the table has commands {lows[i]:g} … {highs[i]:g} of its"
            f" {least:g} … {most:g}; one sweep during which the battery sagged is one curve, so give all"
            " its rows one voltage, or leave the column out: several voltages need a whole sweep each",
            key,
        )
    return float(lows.max()), float(highs.min())


def _resampled(points: FloatArray, neutral: float, command: FloatArray) -> FloatArray:
    """The monotone curve of the points at other commands; neutral makes exactly 0."""
    thrust: FloatArray = np.interp(command, points[:, 0], monotone(points, neutral))
    # A curve that has no point at neutral rises straight through it, as from -0.1 to 0.1 N.
    return sided(command, thrust, neutral)
