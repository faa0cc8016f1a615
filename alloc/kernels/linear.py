"""The closed forms: f = G tau with zero entries dropped, and sums that rows share taken once."""

from collections.abc import Callable
from functools import reduce
from operator import add

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.closed_forms.linear import exactly, usual
from alloc.kernels.entry import all_of
from alloc.kernels.off import reachable, without
from alloc.kernels.tolerance import TOLERANCE
from alloc.nullspace.structure import decompose
from alloc.program import Builder, Program, Scalar, States, Where, select
from alloc.program.sums import dot, product, shared_sums, signed
from alloc.vehicle import Vehicle

FAR = 1e3
"""Demands up to so many times what the limits allow are usual, or their thrusts are looked at [-]."""
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
    """f = G tau, G (n, k) an ``inverse`` of the vehicle; limits are not looked at.

    Where a direction is lost, and where tau is so large that rounding costs the wrench its tolerance, the
    status is PARTIAL. Of ``faults`` it is one program for all.
    """
    builder, G = Builder(vehicle, limits, scalar, faults), inverse(vehicle)
    products = product(G, builder.tau)
    sums, rows = shared_sums(products.rows)
    builder.compute(*products.shared, *sums)
    f = [signed(row, builder.graph) for row in rows]
    parts = [signed(dot(row.tolist(), builder.tau), builder.graph) for row in decompose(vehicle).unreachable]
    if faults:
        f = [*without(builder, dict(enumerate(f)), inverse).thrusts.values()]
        lost = reachable(builder).lost
        parts += [] if lost is None else [lost]
    conditions = []
    for i, part in enumerate(parts):
        part = part.named(f"lost{i}")
        builder.compute(part)
        conditions.append((part >= -TOLERANCE[scalar]) & (part <= TOLERANCE[scalar]))
    if scalar == "double":  # float promises no wrench to 1e-6
        known = [*builder.faults.values()] or [vehicle]
        largest, looked_at = [usual(state, inverse(state)) for state in known], builder.tau
        if min(largest) <= FAR * float(np.linalg.norm(vehicle.wrench_scale)):
            # A weak direction makes that too little: what counts is the thrusts, as in Python.
            largest, looked_at = [*map(exactly, known)], [f[i] for i in vehicle.working.tolist()]
        most = builder.graph.by_fault([each**2 for each in largest])
        conditions.append(reduce(add, [each * each for each in looked_at]) <= most)
    status = select(all_of(conditions), Status.SOLVED, Status.PARTIAL) if conditions else Status.SOLVED
    return builder.program(f, status)
