"""Cascaded generalized inverse: freeze what saturates at its limit, solve the rest again, until none does."""

from alloc.closed_forms.redistribute import NAME, redistribute
from alloc.closed_forms.saturating import Saturating
from alloc.vehicle import Vehicle

FORMULATION = NAME


def build(vehicle: Vehicle) -> Saturating:
    """Prepare the rule, which ``alloc.closed_forms.redistribute`` has."""
    return redistribute(vehicle)
