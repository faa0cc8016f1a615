"""The optimum that keeps the direction: the largest attainable share of the wrench, at least effort."""

from alloc.formulations.scaled import FORMULATION as ANSWERED
from alloc.nullspace.by_level import ByLevel
from alloc.vehicle import Vehicle

FORMULATION = ANSWERED.name


def build(vehicle: Vehicle) -> ByLevel:
    """Prepare to go straight from rest towards the demand as far as it is attainable, at least effort."""
    return ByLevel(vehicle, ANSWERED)
