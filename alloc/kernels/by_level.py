"""Methods that go level by level towards a demand: least effort at the wrench that is reached."""

from functools import reduce
from itertools import pairwise
from math import inf
from operator import add
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.formulations import Formulation, Part
from alloc.kernels.correction import Gap, correct_thrusts, limit_gap
from alloc.kernels.entry import all_thrusters, clamp_thrusts, refuse
from alloc.kernels.exact import piece
from alloc.kernels.failures import shared_states
from alloc.kernels.rules import MEANINGS as RULE
from alloc.kernels.tolerance import MOVED_ERROR
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
    """Program of a formulation with a path; raises NotApplicable for too many facets or steps.

    With ``faults`` one program serves many: a failed thruster has limits of zero. Left out are faults that
    lose a direction where there are several levels, since their steps differ, and faults that leave a
    direction weak or counted in part, since their equations differ, or let levels stop at other shares. If
    the whole vehicle has such a direction, T differs between faults and the program serves it alone.
    """
    first, *others = parts = formulation.parts(vehicle)
    ways = [(part.way.keep, part.way.together) for part in parts]
    known = {
        fault: state
        for fault, state in (shared_states(vehicle) if faults and first.vehicle is vehicle else {}).items()
        if state.mixture[0][1] is state
        and (len(first.way.levels) == 1 or state.rank == vehicle.rank)
        and [(part.way.keep, part.way.together) for part in formulation.parts(state)] == ways
    }
    builder = Builder(first.vehicle, limits, scalar, known)
    answers = [_one(builder, vehicle, first)]
    for part in others:
        builder.fence()
        builder.vehicle = part.vehicle
        answers.append(_one(builder, vehicle, part))
        answers[-1] = answers[-1]._replace(shares=[answers[-1].shares[level] for level in part.level_indices])
    found = _mixed(builder, answers, [part.w for part in others])
    status = select(found.met, Status.SOLVED, Status.PARTIAL)
    return builder.program(all_thrusters(builder, found.thrusts), status, found.shares)


class _Answer(NamedTuple):
    """Answer of one path: thrusts inside the limits, shares, and the condition that all is delivered."""

    thrusts: dict[int, Expression]
    shares: list[Expression]
    met: Expression


def _mixed(builder: Builder, answers: list[_Answer], ws: list[float]) -> _Answer:
    """The weighted sum of answers by ``Formulation.parts``."""
    found = answers[0]
    for (before, one), w in zip(pairwise(answers), ws, strict=True):
        f = {i: found.thrusts[i] + w * (x - before.thrusts[i]) for i, x in one.thrusts.items()}
        builder.compute(*(x.named(f"mix{i}") for i, x in f.items()))
        each = zip(found.shares, one.shares, before.shares, strict=True)
        found = _Answer(f, [x + w * (after - past) for x, after, past in each], found.met & one.met)
    return found._replace(thrusts=clamp_thrusts(builder, found.thrusts, builder.limits)) if ws else found


def _one(builder: Builder, whole: Vehicle, part: Part) -> _Answer:
    """The answer of one path, for the builder's vehicle."""
    vehicle, way = part.vehicle, part.way
    structure, again = decompose(vehicle), builder.limits.again()
    walk = Walk(builder, way, structure.G)
    fixed = [i for i in structure.fixed.tolist() if vehicle.readiness[i]]
    # A block is answered once no later level moves it, with limits that are read again.
    arrival = [walk.arrived(_coupled(vehicle, block)) for block in structure.blocks]
    thrusts, gaps = dict[int, Expression](), list[Gap]()
    for level in range(walk.levels):
        walk.take(level)
        if level == walk.levels - 1:
            refuse(builder, walk.seen, [], exact=False)
        for b, block in enumerate(structure.blocks):
            if arrival[b] == level:
                x, zero = _ends(builder, walk, b, block)
                made = piece(builder, f"{b}", block, x, inf, again, zero)
                if again.at_call:
                    builder.fence()
                builder.compute(*made.before)
                ended = made.thrusts()
                builder.compute(*ended.values())
                gaps += (
                    [limit_gap(builder, i, x, again) for i, x in ended.items()]
                    if made.gaps is None
                    else made.gaps
                )
                thrusts |= ended
        if fixed and walk.arrived(fixed) == level:
            if again.at_call:
                builder.fence()
            ended = {i: lifted(walk.f[i], builder.graph) for i in fixed}
            gaps += [limit_gap(builder, i, x, again) for i, x in ended.items()]
            thrusts |= ended
    found = correct_thrusts(builder, gaps, thrusts, walk, again)
    y = clamp_thrusts(builder, found.thrusts, again)
    # The part of a demand along weak directions does not count as missed.
    lost = (structure if vehicle.rank == whole.rank else decompose(whole)).unreachable
    return _Answer(y, found.shares, _met(builder, lost, walk.reachable.lost, found.shares))


def _coupled(vehicle: Vehicle, block: Block) -> list[int]:
    """The thrusters of a block, and those that H couples with them."""
    linked = np.where(vehicle.readiness > 0, block.N.T @ vehicle.H[block.rows], 0.0)
    return sorted({*block.rows.tolist(), *np.flatnonzero(snapped(linked).any(axis=0)).tolist()})


def _ends(builder: Builder, walk: Walk, b: int, block: Block) -> tuple[dict[int, Expression], Number]:
    """Thrusts x of a block at the end of the path, without their part in the null space; and 0.

    In one dimension x keeps that part, and the second value is the z that removes it.
    """
    vehicle = builder.vehicle
    f = [lifted(each, builder.graph) for each in walk.f]
    x = {i: f[i] for i in block.rows.tolist()}
    if walk.starts_at_rest:  # G tau has no part in the null space
        return x, 0.0
    # N is scaled by its slab in one dimension, else by its largest entries, so that zeros stay zero.
    N = block.N / (np.abs(block.N).max(axis=0) if block.N.shape[1] > 1 else leading(block.N))
    # A full H also couples the block with thrusters that z does not move.
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
    # Over wrench_scale the rows are orthonormal: the sum of squares is the squared error.
    rows = product(lost / MOVED_ERROR[builder.scalar], builder.tau, "pm").rows if len(lost) else []
    missed = [signed(row).named(f"missed{i}") for i, row in enumerate(rows)]
    if by_fault is not None:
        missed.append((by_fault * (1.0 / MOVED_ERROR[builder.scalar])).named("missed_off"))
    if not missed:
        return whole
    squares = reduce(add, [each * each for each in missed])
    return whole & (squares <= 1.0)
