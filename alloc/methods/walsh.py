"""Walsh matrix, T = Q W_f (eq. 18-28): symmetric thrusters only, no limits."""

from alloc.closed_forms.linear import Linear
from alloc.closed_forms.walsh import walsh_inverse
from alloc.kernels import linear
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle

FORMULATION = Linear.formulation
MEANINGS = linear.MEANINGS


def build(vehicle: Vehicle) -> Linear:
    """Prepare f = G tau; raises NotApplicable where a premise of eq. 19 fails, and says which."""
    return Linear(vehicle, walsh_inverse(vehicle))


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same with one multiplication an axis, then additions that rows share: the fast Walsh transform.

    f = 1/m W [0; Q^-1 tau] (eq. 25) or, with a thruster off, eq. 27; raises NotApplicable as ``build``.
    """
    return linear.linear(vehicle, walsh_inverse, limits, scalar)
