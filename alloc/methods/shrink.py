"""Generalized inverse, then all thrusts scaled by one factor until they fit: keeps the wrench's direction."""

from alloc.closed_forms.saturating import Saturating
from alloc.closed_forms.shrink import NAME, shrink
from alloc.vehicle import Vehicle

FORMULATION = NAME


def build(vehicle: Vehicle) -> Saturating:
    """Prepare the rule, which ``alloc.closed_forms.shrink`` has."""
    return shrink(vehicle)
