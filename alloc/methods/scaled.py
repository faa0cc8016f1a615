"""The optimum that keeps the direction: the largest attainable share of the wrench, at least effort."""

from alloc.formulations.scaled import FORMULATION as ANSWERED
from alloc.kernels.by_level import MEANINGS, by_level
from alloc.kernels.rules import doubt
from alloc.live.exact import exact_by_any
from alloc.nullspace.by_level import allocator
from alloc.nullspace.current_cap import CurrentCap
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle

__all__ = ["FORMULATION", "MEANINGS", "build", "doubt", "program", "program_for_all"]
FORMULATION = ANSWERED.name
AZIMUTHS = True


def build(vehicle: Vehicle) -> CurrentCap:
    """Prepare to go straight from rest towards the demand as far as it is attainable, at least effort."""
    return CurrentCap(vehicle, allocator(vehicle, ANSWERED, exact_by_any))


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same with each facet and step written out; raises NotApplicable where these are too many."""
    return by_level(ANSWERED, vehicle, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and many faults."""
    return by_level(ANSWERED, vehicle, limits, scalar, faults=True)
