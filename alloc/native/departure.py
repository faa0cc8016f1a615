"""C of where the way towards a demand begins: thrusts f0, and what is missing of tau there."""

import numpy as np

from alloc.native.bounds import CLimits
from alloc.native.code import Table, Terms, Value, defined, gathered, number, signed_sum
from alloc.reach.edge import INSET, start
from alloc.vehicle import Vehicle


def departure(vehicle: Vehicle, bounds: CLimits, c: Table) -> tuple[list[str], list[Value]]:
    """Definitions, and the thrusts f0 that they define (see ``alloc.reach.edge.start``)."""
    if not bounds.at_call:
        return [], list(np.where(vehicle.readiness > 0, start(vehicle.f_min, vehicle.f_max), 0.0))
    lines, zero = list[str](), number(0.0, c.scalar)
    for i in vehicle.working.tolist():
        low, high = bounds.ends(i)
        lines += [
            defined(f"near{i}", f"within({zero}, {low}, {high})", c),
            defined(f"in{i}", f"o{i} * {c(INSET)}", c),
            defined(f"f{i}", f"near{i} + within(near{i}, in{i}, -in{i})", c),
        ]
    return lines, [f"f{i}" if ready else 0.0 for i, ready in enumerate(vehicle.readiness)]


def largest(vehicle: Vehicle, f0: list[Value]) -> float:
    """Size of the largest of these thrusts, whatever the limits of a call are [N]."""
    return max(abs(f) if isinstance(f, float) else vehicle.f_scale for f in f0)


def missing(vehicle: Vehicle, f0: list[Value], c: Table) -> list[str]:
    """Definitions of n0, tau - T f0."""
    known = vehicle.TP @ [f if isinstance(f, float) else 0.0 for f in f0]
    at_call = any(isinstance(f, str) for f in f0)
    lines, rows = gathered(vehicle.TP, "f", c, "w") if at_call else ([], [[] for _ in known])
    for r, (of_call, fixed) in enumerate(zip(rows, known.tolist(), strict=True)):
        terms: Terms = [(False, f"t{r}"), *((not minus, text) for minus, text in of_call)]
        terms += [(fixed > 0, c(abs(fixed)))] if fixed else []
        lines.append(defined(f"n0_{r}", signed_sum(terms, c.scalar), c))
    return lines
