"""The remarks on the keys ``esc`` and ``cap``: from thrusts to the wire, and what may be drawn."""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from alloc.allocation import FloatArray
from alloc.lint.report import Remark, note, warning
from alloc.vehicle import Vehicle
from alloc.vehicle.current import CurrentTable
from alloc.vehicle.current_file import excesses, measured_current
from alloc.vehicle.esc import Esc
from alloc.vehicle.esc_file import GRAVITY, SHORT, measured, monotone
from alloc.vehicle.keys import EscKeys, VehicleFile

APART = 0.02
"""Share by which two sources of a limit may differ: published curves are rounded to parts in a thousand."""
NOISE = 0.01
"""Share of the largest thrust by which a measured curve may fall before that is worth a remark."""


def on_esc(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on curves that fall or end early, or of another unit, voltage or way round; on coarse steps."""
    if keys.esc is None:
        return
    for i, one in enumerate([keys.esc] if isinstance(keys.esc, EscKeys) else keys.esc):
        yield from _on_points(one)
        yield from _on_dshot(vehicle.esc[i])
        yield from _on_dead_band(vehicle.esc[i])
        yield from _on_no_volts(vehicle.esc[i])
    yield from _on_voltages(vehicle.esc)
    if keys.f_min is None or keys.f_max is None:
        yield from _on_nominal(vehicle)
    yield from _on_each(vehicle)


def _on_points(keys: EscKeys) -> Iterator[Remark]:
    if (curve := measured(keys)) is None:
        linear = "thrust is taken as linear, and alike at every voltage, as no propeller's is"
        yield warning("esc", f"no 'curve': {linear}; measure one")
        return
    yield from _on_copies("curves", curve.volts, curve.points)
    for volts, points in zip(curve.volts, curve.points, strict=True):
        at_volts = "" if np.isnan(volts) else f" at {volts:g} V"
        moved = np.abs(monotone(points, keys.neutral) - points[:, 1])
        most = np.abs(points[:, 1]).max()
        if moved.max() > NOISE * most:
            at = int(moved.argmax())
            yield warning(
                "esc",
                f"the curve{at_volts} is not monotone: {points[at, 1]:g} N at {points[at, 0]:g} is moved"
                f" by {moved[at]:.3g} N; one that never falls stands in for it",
            )
        makes = np.interp(keys.neutral, points[:, 0], points[:, 1])
        if abs(makes) > NOISE * most and keys.neutral not in points[:, 0]:
            yield warning(
                "esc",
                f"the curve{at_volts} makes {makes:.3g} N at neutral, {keys.neutral:g}, where no thrust"
                " is taken for granted; mend one of them",
            )
        if -points[:, 1].min() > points[:, 1].max() > 0:
            yield warning(
                "esc",
                f"astern is stronger than ahead{at_volts} ({points[:, 1].min():g} and"
                f" {points[:, 1].max():g} N); is the curve the other way round?",
            )
    if keys.volts is not None and not curve.volts[0] <= keys.volts <= curve.volts[-1]:
        yield warning(
            "esc",
            f"'volts' is {keys.volts:g} V, but the curve was measured at {curve.volts[0]:g} to"
            f" {curve.volts[-1]:g} V",
        )


def _on_copies(what: str, volts: FloatArray, measured: Sequence[FloatArray]) -> Iterator[Remark]:
    for a, b in combinations(range(len(volts)), 2):
        if len(measured[a]) > 1 and np.array_equal(measured[a], measured[b]):
            yield warning(
                "esc",
                f"the {what} at {volts[a]:g} V and {volts[b]:g} V are the same in all {len(measured[a])}"
                " points, as no propeller's are; one is a copy: measure that voltage or leave it out",
            )


def _on_voltages(escs: Sequence[Esc]) -> Iterator[Remark]:
    """A remark where all curves share one voltage at most: at any other, some thrust was never measured."""
    known = [esc.volts for esc in escs if not np.isnan(esc.volts[0])]
    if not known:
        return
    least, most = max(volts[0] for volts in known), min(volts[-1] for volts in known)
    if least < most:
        return
    shared = "no voltage lies in all curves" if least > most else f"all curves share {most:g} V alone"
    yield (warning if least > most else note)(
        "esc",
        f"{shared}; at another one thrusts count as never measured (status 1 in C): give more voltages, or"
        " the curve without one",
    )


def _on_nominal(vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on limits that were left out: those at 'volts' also hold where the battery has more."""
    if (table := vehicle.by_volts) is None:
        return
    more = (table.f_max - table.f_min)[-1] / (vehicle.f_max - vehicle.f_min)
    i = int(more.argmax())
    if more[i] > 1 + APART and vehicle.esc[i].nominal < table.volts[-1]:
        yield note(
            "esc",
            f"limits were left out, so those at 'volts', {vehicle.esc[i].nominal:g} V, hold at more, too: at"
            f" {table.volts[-1]:g} V {vehicle.called(i)} could give {table.f_min[-1, i]:.3g} …"
            f" {table.f_max[-1, i]:.3g} N, and {vehicle.f_min[i]:.3g} … {vehicle.f_max[i]:.3g} N is all that"
            " is asked; if the battery reaches that, raise 'volts', or write f_min and f_max",
        )


def _on_dshot(esc: Esc) -> Iterator[Remark]:
    """A remark on DShot's 3D mode: 48 is the slowest astern, 1047 the fastest, and more runs ahead."""
    if (esc.low, esc.high) == (48, 2047) and esc.neutral > 48:
        yield warning(
            "esc",
            "if the range is of DShot 3D, its commands astern count the other way: 48 is the slowest and 1047"
            " the fastest; write neutral 0 and range [-1000, 1000], and turn that into DShot's in the driver",
        )


def _on_no_volts(esc: Esc) -> Iterator[Remark]:
    if esc.needs_volts:
        has = f"the curve has {esc.volts[0]:g} to {esc.volts[-1]:g} V"
        more = "so each call must say the voltage; give the usual one as 'volts' in 'esc'"
        yield warning("esc", f"no 'volts', and {has}, {more}")


def _on_dead_band(esc: Esc) -> Iterator[Remark]:
    still = esc.command[(esc.curve == 0).all(axis=0)]
    width = float(np.ptp(still)) if len(still) else 0.0
    if 0 < width < esc.step:
        yield warning(
            "esc",
            f"a step of {esc.step:g} is coarser than the dead band, {width:g}; the smallest thrust jumps",
        )


def _on_each(vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on each thruster's range and limits, said once: one that is not of all names whose it is."""
    named: dict[Remark, list[str]] = {}
    for i in range(vehicle.n):
        for remark in (*_on_range(vehicle.esc[i]), *_on_limits(vehicle, i)):
            named.setdefault(remark, []).append(vehicle.called(i))
    for (level, key, message), names in named.items():
        whose = "" if len(names) == vehicle.n else f"{', '.join(names)}: "
        yield level, key, f"{whose}{message}"


def _on_range(esc: Esc) -> Iterator[Remark]:
    """The range against the commands of the curve, which is given as if the ESC were not reversed."""
    ends = np.array([esc.low, esc.high])
    first, last = np.sort(2 * esc.neutral - ends) if esc.reversed else ends
    start, stop = esc.command[[0, -1]]
    if max(start - first, last - stop) > SHORT * (last - first):
        mirrored = "" if (first, last) == (esc.low, esc.high) else " (mirrored, for 'reversed')"
        yield warning(
            "esc",
            f"of the range {first:g} … {last:g}{mirrored} the curve has {start:g} … {stop:g} alone: no"
            " command beyond is sent, and no more thrust made than at its ends; measure the rest, or narrow"
            " 'range'",
        )


def _on_limits(vehicle: Vehicle, i: int) -> Iterator[Remark]:
    """Limits of the file against the ends of the curve at the same voltage."""
    esc = vehicle.esc[i]
    bare = bool(
        np.isnan(esc.volts[0])
    )  # of a curve without voltages, or of no curve, which ends at the limits
    at = esc.volts[-1] if np.isnan(esc.nominal) else esc.nominal
    sources = [("f_min", "f_max", vehicle.f_min[i], vehicle.f_max[i], at)]
    if (table := vehicle.by_volts) is not None and not bare:
        rows = zip(table.volts, table.f_min[:, i], table.f_max[:, i], strict=True)
        sources += [("volts", "volts", low, high, volts) for volts, low, high in rows]
    for low_key, high_key, low, high, volts in sources:
        if not (bare or esc.volts[0] <= volts <= esc.volts[-1]):
            continue
        ends = [float(side[0]) for side in esc.span(np.array([volts]))]
        for key, said, end in zip((low_key, high_key), (low, high), ends, strict=True):
            if said == 0 or abs(said - end) <= APART * abs(end):
                continue
            if end == 0:
                yield warning(key, f"{said:g} N, but the curve has no thrust that way")
                continue
            factor = said / end
            which = "more than" if factor > 1 else "less than" if factor > 0 else "against"
            numbers = (
                f"{said:g} N is {which} the {end:.4g} N of the curve{'' if bare else f' at {volts:g} V'}"
            )
            if any(abs(factor * unit - 1) <= 5 * APART for unit in (GRAVITY, 1 / GRAVITY)):
                yield warning(key, f"{numbers}, by a factor of about {GRAVITY:.3g}; is one of them in kgf?")
            elif factor > 1:
                yield note(key, f"{numbers}: the ESC can't give it there")
            else:
                yield note(key, numbers)


def on_current(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on what all thrusters draw at once, and on currents that are copies or not convex."""
    if keys.esc is None or any(esc.current is None for esc in vehicle.esc):
        return
    for i, one in enumerate([keys.esc] if isinstance(keys.esc, EscKeys) else keys.esc):
        if not isinstance(current := vehicle.esc[i].current, CurrentTable):
            continue
        if (drawn := measured_current(one)) is not None:
            amps = [points[:, 1] for points in drawn.points]
            yield from _on_copies("currents", drawn.volts, amps)
        yield from _on_convexity(current)
    if not any(esc.needs_volts for esc in vehicle.esc):
        yield from _on_sum(vehicle)


def _on_sum(vehicle: Vehicle) -> Iterator[Remark]:
    """A note with what all draw that the ESCs make within the limits, beside the cap where there is one."""
    draw, (low, high) = vehicle.draw(), vehicle.esc_limits()
    most = draw.largest(low, high)
    volts = next((esc.nominal for esc in vehicle.esc if not np.isnan(esc.nominal)), None)
    at = "" if volts is None else f" at {volts:g} V"
    said = f"all thrusters at their limits together draw {most:.3g} A{at}"
    if vehicle.cap is None:
        yield note("esc", f"{said}; if a fuse gives less, write 'cap'")
    elif not (vehicle.cap.of_power and volts is None):
        yield note("cap", f"{said}; the cap leaves them {vehicle.cap.amps():.3g} A")


def _on_convexity(current: CurrentTable) -> Iterator[Remark]:
    worst = max(excesses(current), key=lambda excess: excess.amps)
    if worst.amps > 0.0:
        at = "" if np.isnan(worst.volts) else f" and {worst.volts:g} V"
        yield note(
            "esc",
            "the current is not convex in the thrust; the convex curve that stands in for it lies above, by"
            f" at most {worst.amps:.2g} A, at {worst.f:.3g} N{at}",
        )
