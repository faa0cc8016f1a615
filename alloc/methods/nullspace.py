"""Exact optimum of eq. 4-5: f = G tau + N z with the shortest z that respects the limits."""

from alloc.kernels import exact as kernels
from alloc.kernels.failures import shared_states
from alloc.kernels.polygons import exact_in_polygons
from alloc.nullspace.allocator import Nullspace, exact
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle

FORMULATION = Nullspace.formulation
AZIMUTHS = True
AZIMUTHS_IN_C = True
MEANINGS = {
    0: "f makes tau, inside the limits, with the least effort",
    2: "no f inside the limits makes tau; f is left alone",
    -1: "there is no such fault; f is left alone",
    -2: "an argument is NaN or infinite; f is left alone",
}


def build(vehicle: Vehicle) -> Nullspace:
    """Prepare the exact answer; raises NotApplicable where a call may take too many steps."""
    return exact(vehicle)


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same with each step written out; raises NotApplicable where that fills a microcontroller."""
    if vehicle.azimuths:
        return exact_in_polygons(vehicle, scalar)
    return kernels.exact(vehicle, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and many faults."""
    return kernels.exact(vehicle, limits, scalar, shared_states(vehicle))
