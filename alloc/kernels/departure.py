"""Start of the way towards a demand: thrusts f0, and what remains of tau there."""

import numpy as np

from alloc.program import Builder, Expression, Limits, Number, within
from alloc.program.sums import Terms, gathered, known, signed
from alloc.reach.edge import INSET, start
from alloc.vehicle import Vehicle


def departure(builder: Builder, limits: Limits) -> list[Number]:
    """The thrusts f0 within limits (see ``alloc.reach.edge.start``)."""
    vehicle = builder.vehicle
    if limits.by_fault:
        return [builder.graph.of_each(each) for each in start(*limits.by_fault).T]
    if not limits.at_call:
        return list(np.where(vehicle.readiness > 0, start(vehicle.f_min, vehicle.f_max), 0.0))
    f: list[Number] = [0.0] * vehicle.n
    for i in vehicle.working.tolist():
        near = within(0.0, *limits.ends(i)).named(f"near{i}")
        inset = (limits.crossing(i) * INSET).named(f"in{i}")
        f[i] = (near + within(near, inset, -inset)).named(f"f{i}")
    return f


def largest(vehicle: Vehicle, f0: list[Number]) -> float:
    """Size of the largest of these thrusts, whatever the limits of a call are [N]."""
    return max(vehicle.f_scale if isinstance(f, Expression) else abs(f) for f in f0)


def remaining(builder: Builder, f0: list[Number]) -> list[Expression]:
    """tau - T f0."""
    vehicle = builder.vehicle
    fixed = vehicle.TP @ [0.0 if isinstance(f, Expression) else f for f in f0]
    of_call = [f for f in f0 if isinstance(f, Expression)]
    moving = vehicle.TP[:, [not known(f) for f in f0]]
    rows = gathered(moving, of_call, "w") if of_call else [Terms() for _ in fixed]
    found = []
    for r, (terms, constant) in enumerate(zip(rows, fixed.tolist(), strict=True)):
        left: Terms = [(False, builder.tau[r]), *((not minus, value) for minus, value in terms)]
        left += [(constant > 0, builder.graph.constant(abs(constant)))] if constant else []
        found.append(signed(left).named(f"n0_{r}"))
    return found
