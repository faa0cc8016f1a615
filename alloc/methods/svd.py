"""Singular value decomposition, T = U S V', whole and with a thruster off (eq. 11-17); no limits."""

from alloc.closed_forms.linear import Linear
from alloc.closed_forms.svd import svd_inverse
from alloc.vehicle import Vehicle

FORMULATION = Linear.formulation


def build(vehicle: Vehicle) -> Linear:
    """Prepare f = G tau, G out of the decomposition of T."""
    return Linear(vehicle, svd_inverse(vehicle))
