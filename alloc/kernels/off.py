"""Thrusters that are off, in one program for many faults.

An optimum within limits is that of the whole vehicle with limits of zero for the thruster; what a fault
leaves without any thruster, a direction, must be left out of a demand first. Of a closed form x = G tau
the others take over what it would do, each a share.
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
"""Most that another thrust may move where one moves to zero: so many times its rounding it gets, too [-]."""


def together(vehicle: Vehicle) -> States:
    """The vehicle, and with each thruster off that its null space moves to zero without large factors.

    With N'HN = I a thrust moves by |N_i| a unit of z, and to move it by one takes z of length 1 / |N_i|.
    """
    far = set[int]()
    for block in decompose(vehicle).blocks:
        moved = np.linalg.norm(block.N, axis=1)
        far |= set(block.rows[moved * MAGNIFIED < moved.max()].tolist())
    return {fault: state for fault, state in states(vehicle).items() if fault not in far}


Inverse = Callable[[Vehicle], FloatArray]
"""Makes the (n, k) matrix G of a closed form."""


def rescaled(vehicle: Vehicle, inverse: Inverse) -> States:
    """Those of ``together`` in which a closed form moves no thrust far for one that is off."""
    known = together(vehicle)
    far = np.abs(changes(known, inverse)).max(axis=1) > MAGNIFIED
    return {fault: state for (fault, state), each in zip(known.items(), far, strict=True) if not each}


def changes(known: States, inverse: Inverse) -> FloatArray:
    """(faults, n) a, by which thrusts G tau change for each newton of the thruster that is off [-].

    Without thruster i G has no row i, and differs by a matrix of rank one, so that this is a G_i.
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


class Without(NamedTuple):
    """Thrusts of a closed form without the thruster that is off, of one program for many faults.

    Attributes
    ----------
    thrusts : x - a x_i by thruster; exactly zero of the one that is off [N]
    off : x_i, what it would do [N]
    a : (faults, n) see ``changes``
    """

    thrusts: dict[int, Expression]
    off: Expression
    a: FloatArray


def without(builder: Builder, x: dict[int, Expression], inverse: Inverse) -> Without:
    """The thrusts x = G tau of a closed form as its ``inverse`` of each fault makes them."""
    graph, a = builder.graph, changes(builder.faults, inverse)
    chosen = {i: [float(fault == i) for fault in builder.faults] for i in x if i in builder.faults}
    parts = [graph.by_fault(each) * x[i] for i, each in chosen.items()]
    off = reduce(add, parts).named("off") if parts else graph.constant(0.0)
    changed = {
        i: (value - graph.by_fault(a[:, i]) * off).named(f"xo{i}") if a[:, i].any() else value
        for i, value in x.items()
    }
    return Without(changed, off, a)


class Reachable(NamedTuple):
    """Part of a demand that a fault leaves reachable, in one program for many faults.

    Attributes
    ----------
    tau : (k,) the demand without the part along the lost direction
    lost : that part, relative to ``wrench_scale``; None where no fault loses a direction
    terms : what ``lost`` adds up, each an entry of tau
    weight : (k,) what is left out of tau where ``lost`` is one, of each fault
    """

    tau: list[Expression]
    lost: Expression | None
    terms: list[Expression]
    weight: FloatArray

    def size(self, builder: Builder, G: FloatArray) -> Number:
        """The largest thrust that a term of the part which is left out would need [N].

        What is left of tau is rounded as these are, also where they cancel.
        """
        if not self.terms:
            return 0.0
        largest: Expression = most(*map(size, self.terms))
        return largest * builder.graph.by_fault(np.abs(self.weight @ G.T).max(axis=1))


def reachable(builder: Builder) -> Reachable:
    """tau - u (v'tau), with v the direction in unit of ``wrench_scale`` and u the wrench of that size.

    One thruster that is off loses one direction at most; of a fault that loses none u and v are zero.
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
