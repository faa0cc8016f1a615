"""Generalized inverse, then each thrust cut at its limit: what most vehicles do, knowingly or not."""

from alloc.closed_forms.clip import NAME, clip
from alloc.closed_forms.saturating import Saturating
from alloc.vehicle import Vehicle

FORMULATION = NAME


def build(vehicle: Vehicle) -> Saturating:
    """Prepare the rule, which ``alloc.closed_forms.clip`` has."""
    return clip(vehicle)
