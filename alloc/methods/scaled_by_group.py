"""The optimum that keeps the direction in each group of axes that share no thruster, at least effort."""

from alloc.formulations.scaled_by_group import FORMULATION as ANSWERED
from alloc.nullspace.by_level import ByLevel
from alloc.vehicle import Vehicle

FORMULATION = ANSWERED.name


def build(vehicle: Vehicle) -> ByLevel:
    """Prepare to go straight towards the demand in each group of axes, at least effort."""
    return ByLevel(vehicle, ANSWERED)
