"""The optimum level by level: the axes that matter most are served first, at least effort."""

from alloc.formulations.priority import FORMULATION as ANSWERED
from alloc.kernels.by_level import MEANINGS, by_level
from alloc.kernels.rules import doubt
from alloc.live.exact import exact_by_any
from alloc.nullspace.by_level import ByLevel, Mixed, allocator
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle

__all__ = ["FORMULATION", "MEANINGS", "build", "doubt", "program", "program_for_all"]
FORMULATION = ANSWERED.name
AZIMUTHS = True


def build(vehicle: Vehicle) -> ByLevel | Mixed:
    """Prepare to go towards the demand level by level of ``vehicle.priority``, at least effort."""
    return allocator(vehicle, ANSWERED, exact_by_any)


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same with each facet and step written out; raises NotApplicable where these are too many."""
    return by_level(ANSWERED, vehicle, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and many faults."""
    return by_level(ANSWERED, vehicle, limits, scalar, faults=True)
