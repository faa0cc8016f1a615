"""Methods that go level by level towards a demand, and give the least effort where the way ends."""

from functools import reduce
from math import inf
from operator import add

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.formulations import Formulation
from alloc.kernels.entry import all_thrusters, inside, refuse
from alloc.kernels.exact import piece
from alloc.kernels.held import Gap, beyond, held
from alloc.kernels.off import together
from alloc.kernels.rules import MEANINGS as RULE
from alloc.kernels.tolerance import HELD
from alloc.kernels.walk import Walk
from alloc.nullspace.region import leading
from alloc.nullspace.structure import Block, decompose
from alloc.program import Builder, Expression, Number, Program, Scalar, Where, least, select
from alloc.program.graph import lifted
from alloc.program.sums import gathered, product, signed, snapped
from alloc.vehicle import Vehicle

MEANINGS = RULE | {
    0: "f makes tau, inside the limits, with the least effort",
    1: "f lies inside the limits and makes a part of tau, with the least effort; share says how much",
}
"""Meaning of each value that the C function of such a method returns."""


def by_level(
    formulation: Formulation, vehicle: Vehicle, limits: Where, scalar: Scalar, *, faults: bool = False
) -> Program:
    """The answer of a formulation with a way; raises NotApplicable for too many facets or steps.

    With ``faults`` it is one program for many: a thruster that is off is one whose limits are zero. Where
    that loses a direction, the steps of several levels are others, so of these it is left out; so is one
    that leaves a direction weak, whose thrusts solve other equations. Where the whole vehicle has a weak
    direction T differs from fault to fault, and the program is for the vehicle alone.
    """
    assert formulation.way is not None
    way, whole = formulation.way(vehicle), vehicle
    vehicle = formulation.subject(vehicle)
    known = {
        fault: state
        for fault, state in (together(vehicle) if faults and vehicle is whole else {}).items()
        if state.strong is state and (len(way.levels) == 1 or state.rank == vehicle.rank)
    }
    builder = Builder(vehicle, limits, scalar, known)
    structure, again = decompose(vehicle), builder.limits.again()
    walk = Walk(builder, way, structure.G)
    fixed = [i for i in structure.fixed.tolist() if vehicle.readiness[i]]
    # A part of the thrusters is answered as soon as no later level moves it, from limits that are read anew.
    arrival = [walk.arrived(_coupled(vehicle, block)) for block in structure.blocks]
    thrusts, gaps = dict[int, Expression](), list[Gap]()
    for level in range(walk.levels):
        walk.take(level)
        if level == walk.levels - 1:
            refuse(builder, walk.seen, [], exact=False)
        for b, block in enumerate(structure.blocks):
            if arrival[b] == level:
                x, zero = _ends(builder, walk, b, block)
                part = piece(builder, f"{b}", block, x, inf, again, zero)
                if again.at_call:
                    builder.fence()
                builder.compute(*part.before)
                ended = part.thrusts()
                builder.compute(*ended.values())
                gaps += (
                    [beyond(builder, i, x, again) for i, x in ended.items()]
                    if part.gaps is None
                    else part.gaps
                )
                thrusts |= ended
        if fixed and walk.arrived(fixed) == level:
            if again.at_call:
                builder.fence()
            ended = {i: lifted(walk.f[i], builder.graph) for i in fixed}
            gaps += [beyond(builder, i, x, again) for i, x in ended.items()]
            thrusts |= ended
    found = held(builder, gaps, thrusts, walk, again)
    y = inside(builder, found.thrusts, again)
    status = select(
        _met(builder, structure.unreachable, walk.reachable.lost, found.shares), Status.SOLVED, Status.PARTIAL
    )
    return builder.program(all_thrusters(builder, y), status, found.shares)


def _coupled(vehicle: Vehicle, block: Block) -> list[int]:
    """The thrusters that a block moves, and those whose effort counts with theirs."""
    linked = np.where(vehicle.readiness > 0, block.N.T @ vehicle.H[block.rows], 0.0)
    return sorted({*block.rows.tolist(), *np.flatnonzero(snapped(linked).any(axis=0)).tolist()})


def _ends(builder: Builder, walk: Walk, b: int, block: Block) -> tuple[dict[int, Expression], Number]:
    """The thrusts x of a block where the way ends, without their part in the null space; and 0.

    In one dimension x keeps that part, and the second number is the z that takes it away.
    """
    vehicle = builder.vehicle
    f = [lifted(each, builder.graph) for each in walk.f]
    x = {i: f[i] for i in block.rows.tolist()}
    if walk.starts_at_rest:  # thrusts that are products with G alone have nothing there
        return x, 0.0
    # In one dimension N is in unit of its slab, else its largest entries are 1: zeros stay zero.
    N = block.N / (np.abs(block.N).max(axis=0) if block.N.shape[1] > 1 else leading(block.N))
    # Where H is full, the effort also couples the block with thrusters that z does not move.
    NtH = np.where(vehicle.readiness > 0, N.T @ vehicle.H[block.rows], 0.0)
    rows = gathered(-np.linalg.solve(NtH[:, block.rows] @ N, NtH), f, f"sz{b}_")
    z = [signed(row).named(f"z{b}_{j}") for j, row in enumerate(rows)]
    if len(z) == 1:
        return x, z[0]
    moves = product(N, z, f"pz{b}_").rows
    return {i: signed([(False, x[i]), *row]).named(f"x{i}") for i, row in zip(x, moves, strict=True)}, 0.0


def _met(
    builder: Builder, lost: FloatArray, by_fault: Expression | None, shares: list[Expression]
) -> Expression:
    """The condition that all of tau is delivered, its part along lost directions included."""
    whole: Expression = least(*shares) >= 1.0
    # In unit of wrench_scale the rows are orthonormal, so the sum of their squares is the square of the miss.
    rows = product(lost / HELD[builder.scalar], builder.tau, "pm").rows if len(lost) else []
    missed = [signed(row).named(f"missed{i}") for i, row in enumerate(rows)]
    if by_fault is not None:
        missed.append((by_fault * (1.0 / HELD[builder.scalar])).named("missed_off"))
    if not missed:
        return whole
    squares = reduce(add, [each * each for each in missed])
    return whole & (squares <= 1.0)
