"""Closed forms: f = G tau without zero entries, and with sums that rows share computed once."""

from collections.abc import Callable
from functools import reduce
from operator import add

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.closed_forms.linear import exactly, usual
from alloc.kernels.entry import conjunction
from alloc.kernels.failures import drop_failed, reachable
from alloc.kernels.tolerance import TOLERANCE
from alloc.nullspace.structure import decompose
from alloc.program import Builder, Program, Scalar, States, Where, select
from alloc.program.sums import dot, product, shared_sums, signed
from alloc.vehicle import Vehicle

FAR = 1e3
"""Largest usual demand over the limits' reach; beyond it the thrusts are compared [-]."""
MEANINGS = {
    0: "f makes tau, with the least effort; limits are not looked at, nor whether tau is finite",
    1: "a direction is lost: f makes the nearest wrench there is; or tau is NaN, infinite or far too large,"
    " and so is f; limits are not looked at",
    -1: "there is no such fault; f is left alone",
}
"""Meaning of each value that the C function of a closed form returns."""


def linear(
    vehicle: Vehicle,
    inverse: Callable[[Vehicle], FloatArray],
    limits: Where,
    scalar: Scalar,
    faults: States | None = None,
) -> Program:
    """Program of f = G tau, G (n, k) an ``inverse`` of the vehicle, without limits.

    PARTIAL if a direction is lost, or if tau is so large that rounding exceeds the wrench's tolerance. One
    program serves all ``faults``.
    """
    builder, G = Builder(vehicle, limits, scalar, faults), inverse(vehicle)
    products = product(G, builder.tau)
    sums, rows = shared_sums(products.rows)
    builder.compute(*products.shared, *sums)
    f = [signed(row, builder.graph) for row in rows]
    parts = [signed(dot(row.tolist(), builder.tau), builder.graph) for row in decompose(vehicle).unreachable]
    if faults:
        f = [*drop_failed(builder, dict(enumerate(f)), inverse).thrusts.values()]
        lost = reachable(builder).lost
        parts += [] if lost is None else [lost]
    conditions = []
    for i, part in enumerate(parts):
        part = part.named(f"lost{i}")
        builder.compute(part)
        conditions.append((part >= -TOLERANCE[scalar]) & (part <= TOLERANCE[scalar]))
    if scalar == "double":  # float promises no 1e-6
        known = [*builder.faults.values()] or [vehicle]
        largest, looked_at = [usual(state, inverse(state)) for state in known], builder.tau
        if min(largest) <= FAR * float(np.linalg.norm(vehicle.wrench_scale)):
            # Too small a bound on a vehicle with a weak direction: compare the thrusts, as Python does.
            largest, looked_at = [*map(exactly, known)], [f[i] for i in vehicle.working.tolist()]
        most = builder.graph.by_fault([each**2 for each in largest])
        conditions.append(reduce(add, [each * each for each in looked_at]) <= most)
    status = select(conjunction(conditions), Status.SOLVED, Status.PARTIAL) if conditions else Status.SOLVED
    return builder.program(f, status)
