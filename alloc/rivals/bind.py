"""A solver's C for one vehicle as an allocator: compiled, loaded, called as this project's own C is."""

from pathlib import Path

from alloc.allocation import Allocator
from alloc.c.bind import native
from alloc.c.compiled import shared_library
from alloc.formulations.hard import FORMULATION as HARD
from alloc.program import Where
from alloc.rivals import load
from alloc.rivals.wrapper import rival
from alloc.solvers import Level
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import promised


def bound(solver: str, vehicle: Vehicle, level: Level | None = None) -> Allocator:
    """A solver's C in double precision as an allocator; raises NotApplicable or NotInstalled.

    Each call begins from the same state, so the same demand gets the same answer. Without a level it is the
    most accurate one.
    """
    tolerances = load(solver).TOLERANCE
    level = level or list(tolerances)[-1]
    return native(
        library(solver, vehicle, level),
        ("answer_fixed", "answer_call"),
        vehicle,
        formulation=HARD.name,
        limited=HARD.limited,
        tolerance=promised(vehicle, tolerances[level]["double"]),
        state=True,
    )


def library(solver: str, vehicle: Vehicle, level: Level = "default") -> Path:
    """A solver's C in double precision, compiled: ``answer_fixed`` and ``answer_call`` answer."""
    forms: tuple[Where, ...] = ("fixed", "call")
    fixed, call = (rival(solver, vehicle, "double", limits, level=level) for limits in forms)
    entries = _ENTRIES.format(
        declared=f"{fixed.declaration}\n{call.declaration}", fixed=fixed.entry, call=call.entry
    )
    return shared_library(solver, {**fixed.own, **call.own, "entries.c": entries}, shared=fixed.shared)


_ENTRIES = """\
{declared}
int answer_fixed(const double *tau, int fault, double *f)
{{
    (void)fault;
    return {fixed}(tau, f);
}}
int answer_call(const double *tau, const double *f_min, const double *f_max, int fault, double *f)
{{
    (void)fault;
    return {call}(tau, f_min, f_max, f);
}}
"""
"""Kernels of this project are told which thruster is off; a solver's C is made for one fault."""
