"""The C around a rival, ``wrapper.c``, with one vehicle's numbers: from a wrench to checked thrusts.

It does in C what ``alloc.live`` does in Python. What it costs is part of what a solver costs on a vehicle.
"""

from importlib import resources
from pathlib import Path
from typing import NamedTuple

from alloc import solvers
from alloc.allocation import Allocator
from alloc.c.bind import native
from alloc.c.compiled import shared_library
from alloc.c.target import function_name
from alloc.c.text import digits
from alloc.errors import NotApplicable, NotInstalled
from alloc.formulations.hard import FORMULATION as HARD
from alloc.kernels.tolerance import SOLVER_ERROR, TOLERANCE
from alloc.live.allocator import PARTIAL_TOLERANCE, UNREACHABLE
from alloc.program import Scalar, Where
from alloc.program.literal import number
from alloc.qp import Posed, pose_hard
from alloc.qp.problem import SHARED
from alloc.rivals import load
from alloc.rivals.c import array, indices
from alloc.solvers import Level
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import promised

DOUBT: dict[Scalar, float] = {"double": 1e-13, "float": 2e-6}
"""Share of the terms in a proof of infeasibility that rounding may have made [-]."""
MEANINGS = {
    0: "f makes tau, inside the limits",
    1: f"f lies inside the limits and misses tau by up to {PARTIAL_TOLERANCE:g}",
    2: "no f inside the limits makes tau, which is proven; f is left alone",
    3: "the solver has no answer that holds; f is left alone",
    -2: "an argument is NaN or infinite; f is left alone",
}
"""Meaning of statuses. Without the check 0, 2 and 3 are the solver's own claim, and f is what it left."""


class Rival(NamedTuple):
    """A solver's C for one vehicle.

    Attributes
    ----------
    entry : name of the function ``int entry(const real *tau, real *f)``; with ``f_min`` and ``f_max`` behind
        tau where limits are arguments
    declaration : C text that declares it
    own : {file name: text} that depends on the vehicle
    shared : {file name: text} that is the same for every vehicle
    """

    entry: str
    declaration: str
    own: dict[str, str]
    shared: dict[str, str]


def rival(
    solver: str,
    vehicle: Vehicle,
    scalar: Scalar = "double",
    limits: Where = "fixed",
    *,
    level: Level = "default",
    checked: bool = True,
) -> Rival:
    """The C of that solver for a vehicle; raises NotApplicable, or NotInstalled with the remedy.

    Without ``checked`` thrusts and status are the solver's own: what the check costs, and what it is worth.
    """
    generator = load(solver)
    if missing := generator.missing():
        raise NotInstalled(f"{solver}: {missing}")
    # In the units that the solver gets in Python, if it is called from there at all.
    posed = pose_hard(vehicle, shared=solvers.shared(solver) if solver in solvers.names() else SHARED)
    if not posed.qp.A.size:
        raise NotApplicable(f"{vehicle.name}: no thruster pushes anything; there is nothing to solve")
    files = generator.generate(posed.qp, scalar, level)
    entry = function_name(vehicle, solver, scalar, limits)
    at_call = f"const {scalar} *f_min, const {scalar} *f_max, " if limits == "call" else ""
    text = (resources.files("alloc.rivals") / "wrapper.c").read_text(encoding="utf-8")
    own = {
        "rival.h": _header(solver, scalar),
        f"{entry}.h": _tables(vehicle, posed, entry, scalar, limits, checked),
        f"{entry}.c": text.replace('"tables.h"', f'"{entry}.h"'),
    }
    declaration = f"int {entry}(const {scalar} *tau, {at_call}{scalar} *f);"
    return Rival(entry, declaration, own | dict(files.own), dict(files.shared))


def _header(solver: str, scalar: Scalar) -> str:
    return f"""\
/* What a solver offers: x within lb and ub with A x = b, least 1/2 x'Hx + g'x. It returns 0 where it claims
 * x, 2 where it claims that there is none, 3 where it gives up, with its multipliers y of the equations. */
{digits(scalar)}

typedef {scalar} real;
#define rival_solve {solver.replace("-", "_")}_rival_solve /* an image may hold several solvers */

int rival_solve(const real *b, const real *lb, const real *ub, real *x, real *y);
"""


def _tables(vehicle: Vehicle, posed: Posed, entry: str, scalar: Scalar, limits: Where, checked: bool) -> str:
    p, m = posed.qp.A.shape
    sizes = {"K": vehicle.k, "N": vehicle.n, "M": m, "P": p, "LOST": len(posed.unreachable)}
    sizes |= {"AT_CALL": int(limits == "call"), "CHECKED": int(checked)}
    doubts = {"MET": SOLVER_ERROR[scalar], "PART": PARTIAL_TOLERANCE, "DOUBT": DOUBT[scalar]}
    doubts |= {"UNREACHABLE": max(UNREACHABLE, TOLERANCE[scalar])}
    lines = [f"#define ENTRY {entry}", *(f"#define {name} {value}" for name, value in sizes.items())]
    lines += [f"#define {name} {number(value, scalar)}" for name, value in doubts.items()]
    arrays = {"b_of_tau": posed.b_of_tau, "unit": posed.unit, "unreachable": posed.unreachable}
    if limits == "call":
        arrays |= {"per_unit": 1.0 / posed.unit}
    else:
        arrays |= {"lb": posed.qp.lb, "ub": posed.qp.ub, "f_min": vehicle.f_min, "f_max": vehicle.f_max}
    per_axis = 1.0 / vehicle.wrench_scale
    T = vehicle.TP[:, posed.working] * per_axis[:, None]
    arrays |= {"T": T, "per_axis": per_axis, "A": posed.qp.A}
    lines += [array(name, values, scalar) for name, values in arrays.items() if values.size]
    return "\n".join([*lines, indices("working", posed.working), ""])


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
