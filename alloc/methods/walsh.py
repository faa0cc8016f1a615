"""Walsh matrix, T = Q W_f (eq. 18-28): symmetric thrusters only, no limits."""

from alloc.closed_forms.linear import Linear
from alloc.closed_forms.walsh import walsh_inverse
from alloc.vehicle import Vehicle

FORMULATION = Linear.formulation


def build(vehicle: Vehicle) -> Linear:
    """Prepare f = G tau; raises NotApplicable where a premise of eq. 19 fails, and says which."""
    return Linear(vehicle, walsh_inverse(vehicle))
