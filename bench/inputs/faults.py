"""Faults as data, read from how users write them: ``3``, ``vertical starboard``, ``3@0.4``, ``each``."""

from collections.abc import Iterable

import msgspec

from alloc import Vehicle
from alloc.errors import VehicleError
from alloc.vehicle.names import is_index


class GivenFault(msgspec.Struct, frozen=True):
    """A thruster that is off or weakened.

    Attributes
    ----------
    thruster : its index or its name; None for every thruster of a vehicle, one at a time
    readiness : p_ii of eq. 2, 0 for off [-]
    """

    thruster: int | str | None
    readiness: float = 0.0


EACH = GivenFault(None)


def parse_fault(text: str) -> GivenFault:
    """The fault that a user wrote as ``THRUSTER`` or ``THRUSTER@READINESS``; raises VehicleError."""
    if text == "each":
        return EACH
    name, at, readiness = text.partition("@")
    try:
        return GivenFault(int(name) if is_index(name) else name, float(readiness if at else 0))
    except ValueError:
        raise VehicleError(
            f"--fault {text[:60]!r}: write a thruster's number or name, as in 3, and where it still works its"
            " share, as in 3@0.4"
        ) from None


def with_fault(vehicle: Vehicle, fault: GivenFault) -> list[Vehicle]:
    """The vehicle with that fault; with EACH, one for each working thruster. Raises VehicleError."""
    if fault.thruster is None:
        return [vehicle.with_fault(i) for i in vehicle.ready]
    return [vehicle.with_fault(fault.thruster, fault.readiness)]


def faulty(vehicle: Vehicle, faults: Iterable[GivenFault | None]) -> list[Vehicle]:
    """The vehicle with each fault in turn; None is the whole vehicle."""
    return [state for f in faults for state in ([vehicle] if f is None else with_fault(vehicle, f))]
