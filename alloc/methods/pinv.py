"""Generalized inverse, f = T* tau (eq. 8-10): one matrix product, no limits."""

from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.linear import Linear
from alloc.kernels import linear
from alloc.kernels.failures import rescaled_states
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle

FORMULATION = Linear.formulation
AZIMUTHS = True
MEANINGS = linear.MEANINGS


def build(vehicle: Vehicle) -> Linear:
    """Prepare f = T* tau for this vehicle, its H and its faults."""
    return Linear(vehicle, generalized_inverse(vehicle))


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same product, zero entries dropped."""
    return linear.linear(vehicle, generalized_inverse, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and many faults."""
    return linear.linear(
        vehicle, generalized_inverse, limits, scalar, rescaled_states(vehicle, generalized_inverse)
    )
