"""Generalized inverse, f = T* tau (eq. 8-10): one matrix product, no limits."""

from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.linear import Linear
from alloc.vehicle import Vehicle

FORMULATION = Linear.formulation


def build(vehicle: Vehicle) -> Linear:
    """Prepare f = T* tau for this vehicle, its H and its faults."""
    return Linear(vehicle, generalized_inverse(vehicle))
