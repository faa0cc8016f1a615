"""Failed thrusters in one program for many faults.

For an optimum within limits, a failed thruster is one with limits of zero; a direction that the fault
leaves without a thruster is first taken out of the demand. For a closed form x = G tau the other thrusters
take over the thrust of the failed one in fixed proportions.
"""

from collections.abc import Callable
from functools import reduce
from operator import add
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.nullspace.structure import decompose
from alloc.program import Builder, Expression, Number, States, most, size, states
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import NOTHING, ROUNDED

MAGNIFIED = 10.0
"""Largest change of another thrust per newton of the failed one; it magnifies rounding as much [-]."""


def shared_states(vehicle: Vehicle) -> States:
    """The vehicle, and its single faults that the null space reaches without large factors.

    With N'HN = I a unit of z moves thrust i by |N_i|, so moving it by 1 N takes a z of length 1 / |N_i|.
    """
    far = set[int]()
    for block in decompose(vehicle).blocks:
        moved = np.linalg.norm(block.N, axis=1)
        far |= set(block.rows[moved * MAGNIFIED < moved.max()].tolist())
    return {fault: state for fault, state in states(vehicle).items() if fault not in far}


Inverse = Callable[[Vehicle], FloatArray]
"""Function from a vehicle to the matrix G (n, k) of a closed form."""


def rescaled_states(vehicle: Vehicle, inverse: Inverse) -> States:
    """Those of ``shared_states`` in which the failed thrust moves no other by more than MAGNIFIED."""
    known = shared_states(vehicle)
    far = np.abs(thrust_changes(known, inverse)).max(axis=1) > MAGNIFIED
    return {fault: state for (fault, state), each in zip(known.items(), far, strict=True) if not each}


def thrust_changes(known: States, inverse: Inverse) -> FloatArray:
    """Changes a (faults, n) of thrusts G tau per newton of the failed thruster [-].

    Without thruster i, G changes by the rank-one matrix a G_i.
    """
    vehicle = known[-1]
    G, units = inverse(vehicle), vehicle.row_lengths
    a = np.zeros((len(known), vehicle.n))
    for row, (fault, state) in enumerate(known.items()):
        axis = int(np.abs(G[fault] * units).argmax())
        if fault >= 0 and abs(G[fault, axis] * units[axis]) > NOTHING * np.abs(G * units).max():
            a[row] = (G - inverse(state))[:, axis] / G[fault, axis]
            a[row, np.abs(a[row]) <= NOTHING] = 0.0
    return a


class FaultThrusts(NamedTuple):
    """Thrusts of a closed form without the failed thruster.

    Attributes
    ----------
    thrusts : x - a x_i by thruster; exactly zero for the failed one [N]
    failed : x_i, the thrust it would give [N]
    a : (faults, n) see ``changes``
    """

    thrusts: dict[int, Expression]
    failed: Expression
    a: FloatArray


def drop_failed(builder: Builder, x: dict[int, Expression], inverse: Inverse) -> FaultThrusts:
    """Turn thrusts x = G tau of the whole vehicle into those of the ``inverse`` of each fault."""
    graph, a = builder.graph, thrust_changes(builder.faults, inverse)
    chosen = {i: [float(fault == i) for fault in builder.faults] for i in x if i in builder.faults}
    parts = [graph.by_fault(each) * x[i] for i, each in chosen.items()]
    off = reduce(add, parts).named("off") if parts else graph.constant(0.0)
    changed = {
        i: (value - graph.by_fault(a[:, i]) * off).named(f"xo{i}") if a[:, i].any() else value
        for i, value in x.items()
    }
    return FaultThrusts(changed, off, a)


class Reachable(NamedTuple):
    """Part of a demand that a fault leaves reachable.

    Attributes
    ----------
    tau : (k,) the demand without its part along the lost direction
    lost : that part over ``wrench_scale`` [-]; None where no fault loses a direction
    terms : the summands of ``lost``, one for each entry of tau
    weight : (faults, k) the wrench left out per unit of ``lost``
    """

    tau: list[Expression]
    lost: Expression | None
    terms: list[Expression]
    weight: FloatArray

    def size(self, builder: Builder, G: FloatArray) -> Number:
        """Largest thrust that a summand of the lost part would need [N], the scale of its rounding."""
        if not self.terms:
            return 0.0
        largest: Expression = most(*map(size, self.terms))
        return largest * builder.graph.by_fault(np.abs(self.weight @ G.T).max(axis=1))


def reachable(builder: Builder) -> Reachable:
    """tau - u (v'tau), with v the lost direction over ``wrench_scale`` and u times it.

    One failed thruster loses at most one direction; u and v are zero where a fault loses none.
    """
    vehicle, graph, tau = builder.vehicle, builder.graph, builder.tau
    scale = vehicle.wrench_scale
    before = decompose(vehicle).unreachable * scale
    directions = np.zeros((len(builder.faults), vehicle.k))
    for row, state in enumerate(builder.faults.values()):
        if state.rank < vehicle.rank:
            now = decompose(state).unreachable * scale
            directions[row] = np.linalg.svd(now - now @ before.T @ before)[2][0]
    directions[np.abs(directions) <= ROUNDED] = 0.0
    if not directions.any():
        return Reachable(tau, None, [], directions)
    moved = np.flatnonzero(directions.any(axis=0)).tolist()
    terms = [graph.by_fault(directions[:, j] / scale[j]) * tau[j] for j in moved]
    lost = reduce(add, terms).named("lost")
    weight = directions * scale
    left = [
        (each - graph.by_fault(weight[:, j]) * lost).named(f"r{j}") if j in moved else each
        for j, each in enumerate(tau)
    ]
    return Reachable(left, lost, terms, weight)
