"""Reads faults as users write them: ``3`` (thruster 3 off), ``3@0.4`` (weakened to 0.4), ``each``."""

from collections.abc import Iterable

from alloc import Vehicle, VehicleError


def faulty(vehicle: Vehicle, faults: Iterable[str]) -> list[Vehicle]:
    """The vehicle with each fault in turn: "" is no fault, "each" is every thruster off, one at a time."""
    vehicles: list[Vehicle] = []
    for fault in faults:
        if fault == "each":
            vehicles += [vehicle.with_fault(i) for i in range(vehicle.n)]
        else:
            vehicles.append(with_fault(vehicle, fault) if fault else vehicle)
    return vehicles


def with_fault(vehicle: Vehicle, fault: str) -> Vehicle:
    """The vehicle with the fault "3" (thruster 3 off) or "3@0.4" (weakened to 0.4); raises VehicleError."""
    thruster, _, readiness = fault.partition("@")
    try:
        return vehicle.with_fault(int(thruster), float(readiness or 0))
    except ValueError:
        raise VehicleError(f"--fault {fault}: write the thruster's number, as in 3, or 3@0.4") from None
