"""The C of each method for a vehicle: what this project generates, and OSQP's own to compare with."""

import numpy as np

from alloc import NotApplicable, UnknownName, Vehicle, catalogue, pose_hard
from alloc.formulations import EXACT_METHODS
from alloc.native import RECIPES, function_name, sources
from alloc.native.bounds import Where, arguments
from alloc.native.code import Scalar
from alloc.solvers import osqp
from bench.emulation.kernel import Kernel, braced

OSQP = "qp/osqp@generated"
OWN = {entry.name: entry.twin for entry in catalogue() if entry.twin}
"""Methods that this project generates C for, each to its twin in Python."""
METHODS = (*OWN, OSQP)


def build_kernel(method: str, vehicle: Vehicle, scalar: Scalar, limits: Where = "fixed") -> Kernel:
    """The C of that method for a vehicle; raises UnknownName, or NotApplicable with the reason."""
    check(method)
    if method == OSQP:
        if limits == "call":
            raise NotApplicable(f"{OSQP}: only the demand is new at each call of this C")
        return _osqp(vehicle, scalar)
    return _native(method, vehicle, scalar, limits)


def check(method: str) -> None:
    """Raise UnknownName for a method that has no C."""
    if method not in METHODS:
        raise UnknownName(f"no C is generated for method '{method}'; there is {', '.join(METHODS)}")


def _native(method: str, vehicle: Vehicle, scalar: Scalar, limits: Where) -> Kernel:
    kernel = OWN[method]
    name = function_name(vehicle, kernel, scalar, limits)
    levels = RECIPES[kernel].levels(vehicle)
    shares = f"\nstatic {scalar} share[{levels}];" if levels else ""
    return Kernel(
        method=method,
        twin=kernel,
        scalar=scalar,
        k=vehicle.k,
        n=vehicle.n,
        entry=name,
        declaration=f'#include "{name}.h"{shares}',
        arguments=arguments(limits, levels, "-1"),
        sources=sources(vehicle, kernel, scalar, limits=limits),
        limits=limits,
    )


def _osqp(vehicle: Vehicle, scalar: Scalar) -> Kernel:
    """OSQP's files, and around them the same maps to and from its variables as ``qp/osqp`` has in Python."""
    posed = pose_hard(vehicle)
    if len(posed.unreachable):
        raise NotApplicable(
            f"{vehicle.name}: some wrenches no thruster makes; OSQP's C has no equation for them"
        )
    p, m = posed.qp.A.shape
    rows, equal = p + m, np.zeros(p)
    low, high = (np.concatenate([equal, limits]) for limits in (posed.qp.lb, posed.qp.ub))
    function = f"int osqp_allocate(const {scalar} *tau, {scalar} *f)"
    adapter = f"""\
#include "osqp.h"
#include "workspace.h"

static const {scalar} b_of_tau[{p}][{vehicle.k}] = {{{", ".join(map(braced, posed.b_of_tau))}}};
static {scalar} low[{rows}] = {braced(low)}, high[{rows}] = {braced(high)};
static const int working[{m}] = {{{", ".join(str(i) for i in posed.working)}}};
static const {scalar} unit[{m}] = {braced(posed.unit)};

{function}
{{
    for (int i = 0; i < {p}; i++) {{
        low[i] = 0;
        for (int j = 0; j < {vehicle.k}; j++)
            low[i] += b_of_tau[i][j] * tau[j];
        high[i] = low[i];
    }}
    osqp_update_data_vec(&solver, OSQP_NULL, low, high);
    osqp_solve(&solver);
    for (int i = 0; i < {m}; i++)
        f[working[i]] = unit[i] * solver.solution->x[i];
    return (int)solver.info->status_val;
}}
"""
    files = osqp.generate(posed.qp, use_float=scalar == "float")
    return Kernel(
        method=OSQP,
        twin=EXACT_METHODS[0],
        solver="osqp",
        scalar=scalar,
        k=vehicle.k,
        n=vehicle.n,
        entry="osqp_allocate",
        declaration=f"{function};",
        arguments="tau, f",
        sources=files | {"osqp_allocate.c": adapter},
    )
