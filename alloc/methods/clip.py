"""Generalized inverse, then each thrust cut at its limit: what most vehicles do, knowingly or not."""

from alloc.allocation import FloatArray
from alloc.closed_forms.saturating import Bounds, PolygonSaturating, Saturating
from alloc.kernels import rules
from alloc.program import Builder, Expression, Program, Scalar, Where
from alloc.vehicle import Vehicle

FORMULATION = "clip"
AZIMUTHS = True
MEANINGS = rules.MEANINGS
doubt = rules.doubt


def build(vehicle: Vehicle) -> Saturating:
    """Prepare f = clip(T* tau, f_min, f_max), T* of eq. 9; forces that turn go straight to their polygons."""
    if vehicle.azimuths:
        return PolygonSaturating(vehicle, FORMULATION, lambda tau, f: (f, 1))
    return Saturating(vehicle, FORMULATION, _leave, _leave_many)


def _leave(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
    return f, 1  # Saturating clips the thrusts that are beyond a limit


def _leave_many(taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    return F


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same for a demand within any limits."""
    return rules.apply_rule(_kept, vehicle, limits, scalar)


def program_for_all(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """One program for the vehicle and many faults."""
    return rules.apply_rule(_kept, vehicle, limits, scalar, rules.shared_states(vehicle, scalar))


def _kept(builder: Builder, x: dict[int, Expression]) -> rules.RuleAnswer:
    return rules.RuleAnswer(x)
