"""The ESCs that the key ``esc`` of a vehicle file describes."""

from collections.abc import Sequence

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from alloc.vehicle.curve import LARGEST_COMMAND, SHORT, ThrustCurve, measured, monotone, sided
from alloc.vehicle.esc import Esc
from alloc.vehicle.keys import EscKeys
from alloc.vehicle.limits import VoltageTable
from alloc.vehicle.names import listed

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


def limits_of(made: Sequence[Esc]) -> tuple[FloatArray, FloatArray]:
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


def table_of(made: Sequence[Esc]) -> VoltageTable | None:
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
