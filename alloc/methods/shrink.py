"""Generalized inverse, then all thrusts scaled by one factor until they fit: keeps the wrench's direction."""

from alloc.allocation import FloatArray
from alloc.closed_forms.load import LEAST, load, loads
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.kernels import rules
from alloc.kernels.fit import fit_to_limits
from alloc.program import Program, Scalar, Where
from alloc.vehicle import Vehicle

FORMULATION = "shrink"
MEANINGS = rules.MEANINGS
doubt = rules.doubt


def build(vehicle: Vehicle) -> Saturating:
    """Prepare f = s T* tau, s the largest factor in [0, 1] that brings every excess to its limit.

    s = 1 / max(1, x_i / far_i) with far_i the limit on x_i's side of zero, at least LEAST away, so that s is
    continuous in tau. Shrinking helps against a limit on the far side of zero only. A thrust that is too
    small for a thruster that must always push (f_min > 0) is raised to it, which turns the wrench; and a
    thruster that can't reverse but is asked to leaves next to nothing of s.
    """
    least = LEAST * vehicle.f_scale

    def one(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        s = 1.0 / load(f, limits.pairs, least)
        return [s * x for x in f], 1

    def each(taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        shrunk: FloatArray = (1.0 / loads(F, low, high, least))[:, None] * F
        return shrunk

    return Saturating(vehicle, FORMULATION, one, each)


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same for a demand within any limits."""
    return rules.apply_rule(fit_to_limits, vehicle, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and many faults."""
    return rules.apply_rule(fit_to_limits, vehicle, limits, scalar, rules.shared_states(vehicle, scalar))
