"""Exact optimum of eq. 4-5: f = G tau + N z with the shortest z that respects the limits."""

from alloc.nullspace.allocator import Nullspace, exact
from alloc.vehicle import Vehicle

FORMULATION = Nullspace.formulation


def build(vehicle: Vehicle) -> Nullspace:
    """Prepare the exact answer; raises NotApplicable where a call may take too many steps."""
    return exact(vehicle)
