"""Measured curves of thrust over command: read, shipped, and made to rise."""

from importlib import resources
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import FileError, VehicleError
from alloc.files.textfile import read_text
from alloc.vehicle.keys import EscKeys, Points

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
}
"""What a column of a curve may be called, in small letters; makers' own headers among them."""

OTHER_MARKS = {";": "semicolons", "\t": "tabs"}
"""What else may stand between the cells of a table, and is not read here."""


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
    if isinstance(keys.curve, str):
        table = resources.files("alloc") / "vehicles" / f"{keys.curve}.csv"
        if "/" in keys.curve or not table.is_file():
            raise VehicleError(
                f"{key}.curve: {keys.curve[:60]!r} is no shipped curve and no CSV; there are"
                f" {', '.join(shipped_curves())}",
                key,
            )
        by_volts = read_curve(Path(str(table)))
    else:
        by_volts = keys.curve
    # Single points at several voltages are one sweep under a battery that sags, which `escs` says of them.
    fewest = 2 if len(by_volts) == 1 else 1
    at: list[tuple[float, FloatArray]] = []
    for text, points in by_volts.items():
        try:
            volts = float(text) if text else (np.nan if keys.volts is None else keys.volts)
        except ValueError:
            volts = -1.0
        if not (np.isnan(volts) or 0 < volts < LARGEST_COMMAND):
            raise VehicleError(f"{key}.curve: {text[:40]!r} is no voltage; give a number of volts", key)
        array = np.array(sorted(points), dtype=np.float64).reshape(-1, 2)
        if len(array) < fewest or not (np.abs(array) <= LARGEST_COMMAND).all():
            raise VehicleError(
                f"{key}.curve: at {text or 'no'} V give two or more pairs [command, N], none beyond"
                f" {LARGEST_COMMAND:g}",
                key,
            )
        if not (np.diff(array[:, 0]) > 0).all():
            twice = array[np.flatnonzero(np.diff(array[:, 0]) == 0)[0], 0]
            raise VehicleError(
                f"{key}.curve: command {twice:g} stands twice at {text or 'no'} V; keep one, or their mean",
                key,
            )
        at.append((volts, array))
    at.sort(key=lambda entry: entry[0])
    found = np.array([volts for volts, _ in at])
    if not at or (len(at) > 1 and not (np.diff(found) > 0).all()):
        raise VehicleError(f"{key}.curve: give different voltages, each with its pairs [command, N]", key)
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


def read_curve(path: Path) -> Points:
    """The points of a CSV with columns command, N or kgf, and volts, by voltage ("" without that column).

    Lines that begin with ``#`` are comments; further columns are left out. Raises FileError.
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
        except (ValueError, IndexError):
            raise FileError("a number is missing or is none; mend that row", path=path, line=line) from None
        if not np.isfinite([command, value]).all():
            raise FileError("holds NaN or infinity; mend that row", path=path, line=line)
        found.setdefault(volts, []).append((command, value * (GRAVITY if force == "kgf" else 1.0)))
    return found


def with_curve_read(keys: EscKeys, folder: Path) -> EscKeys:
    """The keys with the points of a curve's CSV, whose path starts at ``folder``; raises FileError."""
    if not isinstance(keys.curve, str) or keys.curve in shipped_curves():
        return keys
    return msgspec.structs.replace(keys, curve=read_curve(folder / keys.curve))


def sided(command: FloatArray, f: FloatArray, neutral: float) -> FloatArray:
    """f without what lies on the wrong side of neutral: none above 0 below it, none below 0 above it."""
    return np.clip(f, np.where(command < neutral, -np.inf, 0.0), np.where(command > neutral, np.inf, 0.0))
