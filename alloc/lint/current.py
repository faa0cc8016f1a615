"""The remarks on what thrusters draw: the keys ``esc.current`` and ``cap`` of a vehicle file."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from alloc.lint.report import Level
from alloc.vehicle import Vehicle
from alloc.vehicle.current import CurrentTable
from alloc.vehicle.current_file import excesses, measured_current
from alloc.vehicle.keys import EscKeys, VehicleFile


def on_current(keys: VehicleFile, vehicle: Vehicle) -> Iterator[tuple[Level, str, str]]:
    """Remarks on what all thrusters draw at once, and on currents that are copies or not convex."""
    if keys.esc is None or any(esc.current is None for esc in vehicle.esc):
        return
    for i, one in enumerate([keys.esc] if isinstance(keys.esc, EscKeys) else keys.esc):
        yield from _on_copies(one)
        if isinstance(current := vehicle.esc[i].current, CurrentTable):
            yield from _on_convexity(current)
    if not any(esc.needs_volts for esc in vehicle.esc):
        yield from _on_sum(vehicle)


def _on_sum(vehicle: Vehicle) -> Iterator[tuple[Level, str, str]]:
    """A note with what all draw that the ESCs make within the limits, beside the cap where there is one."""
    draw, (low, high) = vehicle.draw(), vehicle.esc_limits()
    most = draw.largest(low, high)
    volts = next((esc.nominal for esc in vehicle.esc if not np.isnan(esc.nominal)), None)
    at = "" if volts is None else f" at {volts:g} V"
    said = f"all thrusters at their limits together draw {most:.3g} A{at}"
    if vehicle.cap is None:
        yield "note", "esc", f"{said}; if a fuse gives less, write 'cap'"
    elif not (vehicle.cap.of_power and volts is None):
        yield "note", "cap", f"{said}; the cap leaves them {vehicle.cap.amps():.3g} A"


def _on_copies(keys: EscKeys) -> Iterator[tuple[Level, str, str]]:
    if (measured := measured_current(keys)) is None:
        return
    for a, b in combinations(range(len(measured.volts)), 2):
        if np.array_equal(measured.points[a][:, 1], measured.points[b][:, 1]):
            yield (
                "warning",
                "esc",
                f"the currents at {measured.volts[a]:g} V and {measured.volts[b]:g} V are the same in all"
                f" {len(measured.points[a])} points, as no propeller's are; one is a copy: measure that"
                " voltage or leave it out",
            )


def _on_convexity(current: CurrentTable) -> Iterator[tuple[Level, str, str]]:
    worst = max(excesses(current), key=lambda excess: excess.amps)
    if worst.amps > 0.0:
        at = "" if np.isnan(worst.volts) else f" and {worst.volts:g} V"
        yield (
            "note",
            "esc",
            "the current is not convex in the thrust; the convex curve that stands in for it lies above, by"
            f" at most {worst.amps:.2g} A, at {worst.f:.3g} N{at}",
        )
