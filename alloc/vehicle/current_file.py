"""The currents that ``esc.current`` and a curve's CSV describe, and the key ``cap`` of a vehicle file."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from alloc.vehicle.current import Cap, Current, CurrentTable, PowerLaw
from alloc.vehicle.esc import Esc, esc_draw
from alloc.vehicle.esc_file import (
    ThrustCurve,
    by_voltage,
    measured,
    monotone,
    read_columns,
    shipped_curve,
    sided,
)
from alloc.vehicle.keys import CapKeys, EscKeys

NOISE = 0.02
"""Share of the largest current by which a measured one may fall away from neutral: clamps resolve no more."""
POWERS = (1.0, 4.0)
"""Powers that a law may have [-]: below 1 the problem is not convex, and no propeller has more than 2."""


def with_currents(escs: Sequence[Esc], keys: EscKeys | Sequence[EscKeys]) -> tuple[Esc, ...]:
    """The ESCs of a file with their currents; those that are alike share one. Raises VehicleError."""
    if isinstance(keys, EscKeys):
        shared = read_current(keys, "esc")
        whole = {esc: replace(esc, current=shared) for esc in dict.fromkeys(escs)}
        return tuple(whole[esc] for esc in escs)
    each = [read_current(one, f"esc[{i}]") for i, one in enumerate(keys)]
    return tuple(replace(esc, current=current) for esc, current in zip(escs, each, strict=True))


def read_current(keys: EscKeys, key: str) -> Current | None:
    """The current of an ESC's keys; None where nothing says. Raises VehicleError."""
    if keys.current is not None and any(isinstance(entry, (int, float)) for entry in keys.current.values()):
        return _law(keys.current, key)
    if (pairs := measured_current(keys, key)) is None:
        return None
    return CurrentTable(pairs.volts, pairs.points)


def measured_current(keys: EscKeys, key: str = "esc") -> ThrustCurve | None:
    """Thrusts and currents (p, 2) [N, A] as measured, by voltage; None without. Raises VehicleError."""
    given = keys.current
    if given is None and isinstance(keys.curve, str):
        given = dict(read_columns(shipped_curve(keys.curve, key))[1]) or None
    if given is None:
        return None
    points = {volts: pairs for volts, pairs in given.items() if isinstance(pairs, list)}
    currents = by_voltage(points, keys.volts, f"{key}.current", "A")
    if (curve := measured(keys, key)) is None:
        raise VehicleError(
            f"{key}.current: got amperes by command without thrusts, expected 'curve' beside them, or"
            " {ahead: …, astern: …}",
            key,
        )
    each = []
    for volts, pairs in zip(currents.volts, currents.points, strict=True):
        same = np.flatnonzero((curve.volts == volts) | (np.isnan(curve.volts) & np.isnan(volts)))
        if not same.size:
            known = ", ".join(f"{known:g}" for known in curve.volts)
            raise VehicleError(
                f"{key}.current: got amperes at {volts:g} V without thrusts, expected voltages of the curve,"
                f" {known}",
                key,
            )
        each.append(_by_thrust(pairs, curve.points[int(same[0])], keys.neutral, volts, key))
    return ThrustCurve(currents.volts, tuple(each))


def _by_thrust(pairs: FloatArray, thrusts: FloatArray, neutral: float, volts: float, key: str) -> FloatArray:
    """Thrusts with their largest current (p, 2) [N, A], and rest with that of neutral."""
    at = "" if np.isnan(volts) else f" at {volts:g} V"
    command, amps = pairs.T
    if (amps < 0).any():
        i = int(amps.argmin())
        raise VehicleError(f"{key}.current: got {amps[i]:g} A at {command[i]:g}{at}, expected 0 or more", key)
    outwards = np.where(command[1:] <= neutral, -1.0, 1.0) * np.diff(amps)
    outwards[(command[:-1] < neutral) & (command[1:] > neutral)] = 0.0
    if outwards.min(initial=0.0) < -NOISE * amps.max():
        i = int(outwards.argmin())
        raise VehicleError(
            f"{key}.current: got {amps[i]:g} A at {command[i]:g} and {amps[i + 1]:g} A at"
            f" {command[i + 1]:g}{at}, expected currents that do not fall away from neutral, {neutral:g}",
            key,
        )
    made = np.interp(command, thrusts[:, 0], monotone(thrusts, neutral))
    f = np.append(sided(command, made, neutral), 0.0)
    current = np.append(np.where(f[:-1] == 0.0, 0.0, amps), np.interp(neutral, command, amps))
    distinct = np.unique(f)
    if len(distinct) < 2:
        raise VehicleError(f"{key}.current: got currents at rest{at} alone, expected some under thrust", key)
    return np.column_stack([distinct, [current[f == thrust].max() for thrust in distinct]])


def _law(given: dict[str, float | list[tuple[float, float]]], key: str) -> PowerLaw:
    numbers = {"power": 1.5} | given
    if set(numbers) != {"ahead", "astern", "power"}:
        raise VehicleError(
            f"{key}.current: got {', '.join(given)[:60]}, expected ahead, astern, and power unless 1.5",
            key,
        )
    for name, least, most in (("ahead", 0.0, np.inf), ("astern", 0.0, np.inf), ("power", *POWERS)):
        value = numbers[name]
        if not isinstance(value, (int, float)) or not least <= value < most or value == 0.0:
            wanted = "a number above 0 [A/N^power]" if least == 0.0 else f"{least:g} to {most:g}"
            raise VehicleError(f"{key}.current: {name}: got {str(value)[:40]}, expected {wanted}", key)
    ahead, astern, power = (
        float(value)
        for name in ("ahead", "astern", "power")
        if isinstance(value := numbers[name], (int, float))
    )
    return PowerLaw(ahead, astern, power)


def read_cap(keys: CapKeys, name: str, escs: Sequence[Esc], f_min: FloatArray, f_max: FloatArray) -> Cap:
    """The cap of a file; raises VehicleError, as where the least thrusts (n,) [N] draw more."""
    given = {key: value for key in ("amps", "watts") if (value := getattr(keys, key)) is not None}
    if len(given) != 1:
        raise VehicleError(f"cap: got {' and '.join(given) or 'neither'}, expected one of amps, watts", "cap")
    ((key, most),) = given.items()
    if not most > 0.0:
        raise VehicleError(f"cap.{key}: got {most:g}, expected a number above 0", "cap")
    if not 0.0 <= keys.reserve < most:
        raise VehicleError(
            f"cap.reserve: got {keys.reserve:g}, expected 0 or more, and less than {key}, {most:g}", "cap"
        )
    if not escs or any(esc.current is None for esc in escs):
        raise VehicleError("cap: got a cap without currents, expected 'current' in 'esc'", "cap")
    volts = next((esc.nominal for esc in escs if not np.isnan(esc.nominal)), None)
    cap = Cap(most, keys.reserve, key == "watts", volts)
    if any(esc.needs_volts for esc in escs) or (cap.of_power and volts is None):
        return cap  # without a voltage nothing is known of either
    left = cap.amps()
    least = float(esc_draw(name, escs, None).amps(np.clip(0.0, f_min, f_max)).sum())
    if not least < left:
        raise VehicleError(
            f"cap: got {left:.4g} A for the thrusters, expected more than the {least:.4g} A that they draw at"
            " their least thrusts",
            "cap",
        )
    return cap


class Excess(NamedTuple):
    """Largest distance of the convex current above the measured one, at one voltage.

    Attributes
    ----------
    volts : [V], NaN where none is known
    amps, f : the most that it adds [A], and the thrust there [N]
    """

    volts: float
    amps: float
    f: float


def excesses(table: CurrentTable) -> list[Excess]:
    """The most that the convex curve lies above the measured one, at each voltage."""
    found = []
    for volts, points, pieces in zip(table.volts, table.measured, table.convex, strict=True):
        above = pieces.draws(points[:, 0]) - points[:, 1]
        i = int(above.argmax())
        found.append(Excess(float(volts), float(above[i]), float(points[i, 0])))
    return found
