"""Limits of each demand, from columns of a log: ``volts``, ``f0_min``, ``bow port_max`` and so on."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.errors import DemandError, VehicleError
from alloc.vehicle.limits import VoltageTable
from bench.inputs.columns import VOLTS, Column, TableHeader, named_column, split

_LIMIT = re.compile(r"f(?P<thruster>\d{1,9})_(?P<side>min|max)")
_SIDE = re.compile("minimum|maximum|min|max|lower|upper|lb|ub")


def limit_columns(
    header: TableHeader, thrusters: Sequence[str], given: Mapping[str, str], found: Mapping[str, Column]
) -> dict[str, Column]:
    """Columns that hold limits, by name: ``volts`` [V], ``f3_min`` [N].

    Parameters
    ----------
    thrusters : their names; ``bow port_min`` is ``f0_min`` where bow port is the first
    given, found : names as the user states them, by quantity, and the columns found by these

    Raises DemandError for one twice, in another unit, or spelt otherwise, as ``f_max3``: a limit that is left
    out gives thrusts beyond it.
    """
    limits: dict[str, Column] = {}
    named = [(i, name) for i, name in enumerate(thrusters) if name]
    places = {f"{name}_{side}": f"f{i}_{side}" for i, name in named for side in ("min", "max")}
    others = {column.place for quantity, column in found.items() if quantity in given}
    for i, (column, below) in enumerate(zip(header.names, header.units, strict=True)):
        bare, unit = split(column, below)
        name = places.get(bare) or bare.lower()
        if i in others:
            continue
        if name != VOLTS and not _LIMIT.fullmatch(name):
            if _looks_like_limit(bare, [name for _, name in named]):
                also = "".join(f", or {name}_min" for _, name in named[:1])
                raise DemandError(
                    f"{header.place}: column {column[:40]!r} looks like a limit,"
                    f" expected f0_min, f0_max{also}; rename it"
                )
            continue
        if name in limits:
            raise DemandError(f"{header.place}: column {name!r} stands twice; keep one")
        factors = {"": 1.0, "V": 1.0, "mV": 1e-3} if name == VOLTS else {"": 1.0, "N": 1.0}
        if (unit := unit.strip()) not in factors:
            raise DemandError(f"{header.place}: {column!r} is in {unit}, expected N, or V or mV for volts")
        limits[name] = Column(i, column, factors[unit], unit)
    if VOLTS in given:
        limits[VOLTS] = named_column(header, VOLTS, given)
    return limits


def _looks_like_limit(name: str, thrusters: Sequence[str]) -> bool:
    """True for a side beside a thruster, its number or a word for force, however they are written."""
    squeezed, *names = (re.sub(r"[\W_]", "", each.lower()) for each in (name, *thrusters))
    rest, sides = _SIDE.subn("", squeezed, count=1)
    force = re.fullmatch(r"f?\d*", re.sub("force|thruster|thrust|limit|lim", "", rest))
    return bool(sides and rest and (force or rest in names))


def row_limits(
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
                f"{path}: column {name!r}: got thruster {i}, expected 0 to {vehicle.n - 1} of {vehicle.name}"
            )
        if match["side"] == "min":
            low[:, i] = np.maximum(low[:, i], values)
        else:
            high[:, i] = np.minimum(high[:, i], values)
    off = vehicle.readiness == 0
    return np.where(off, 0.0, low), np.where(off, 0.0, high)


def row_supply(
    vehicle: Vehicle, cap: str | None, volts: FloatArray | None, count: int
) -> list[dict[str, float]]:
    """The arguments cap [A] and volts [V] of each of ``count`` calls; none without a cap.

    ``cap`` are amperes, or ``file`` for the vehicle's own; volts (count,) are those of the demands, None for
    the nominal one. Raises DemandError for another word, VehicleError for a vehicle without a cap.
    """
    if cap is None:
        return [{}] * count
    at: list[dict[str, float]] = [{}] * count if volts is None else [{"volts": float(v)} for v in volts]
    if cap == "file":
        if vehicle.cap is None:
            raise VehicleError(
                f"{vehicle.name}: has no cap for --cap file; add 'cap' to its file, or give amperes", "cap"
            )
        return [{"cap": vehicle.cap.amps(**each), **each} for each in at]
    try:
        amps = float(cap)
    except ValueError:
        raise DemandError(f"--cap: got {cap[:40]!r}, expected a number of amperes, or file") from None
    return [{"cap": amps, **each} for each in at]


def _by_volts(path: Path, volts: FloatArray, vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    table: VoltageTable | None = vehicle.by_volts
    if table is None:
        raise DemandError(
            f"{path}: column 'volts': {vehicle.name} has no limits by voltage; add 'volts' to its file"
        )
    least, most = table.volts[0], table.volts[-1]
    outside = np.flatnonzero(~((volts >= least) & (volts <= most)))
    if outside.size:
        raise DemandError(
            f"{path}: volts of demand {outside[0]} (counted from 0): got {volts[outside[0]]:g} V, expected"
            f" {least:g} to {most:g} V as in the vehicle's table; cut the row out, extend the table, or state"
            " the unit: --columns 'volts=NAME [mV]'"
        )
    return table.between(volts)
