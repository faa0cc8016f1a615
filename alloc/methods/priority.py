"""The optimum level by level: the axes that matter most are served first, at least effort."""

from alloc.formulations.priority import FORMULATION as ANSWERED
from alloc.nullspace.by_level import ByLevel
from alloc.vehicle import Vehicle

FORMULATION = ANSWERED.name


def build(vehicle: Vehicle) -> ByLevel:
    """Prepare to go towards the demand level by level of ``vehicle.priority``, at least effort."""
    return ByLevel(vehicle, ANSWERED)
