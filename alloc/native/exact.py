"""C99 of the exact method for one vehicle: the tables of ``alloc.nullspace`` written out as straight code."""

from typing import NamedTuple

from alloc.errors import NotApplicable
from alloc.native.code import (
    TOLERANCE,
    Table,
    between,
    dot,
    fold,
    names,
    number,
    product,
    reached,
    signed_sum,
    term,
)
from alloc.native.steps import Limits, nearest
from alloc.nullspace.region import Region, prepare
from alloc.nullspace.structure import Block, Structure, decompose
from alloc.vehicle import Vehicle

STEPS_LIMIT = 500
"""Most steps of a block: each is written out, and more would fill a microcontroller's flash."""


class Piece(NamedTuple):
    """What one block of the null space adds to the kernel.

    Attributes
    ----------
    before : statements that the conditions need
    conditions : C conditions that hold unless the demand is infeasible
    after : statements for when the conditions of all blocks hold
    thrusts : C expression of the thrust of each thruster in the block
    """

    before: list[str]
    conditions: list[str]
    after: list[str]
    thrusts: dict[int, str]


def body(vehicle: Vehicle, c: Table) -> list[str]:
    """Statements that turn t0, t1, … into f[0], f[1], … or return INFEASIBLE with f untouched."""
    structure = decompose(vehicle)
    lines, conditions = _closed_form(vehicle, structure, c)
    pieces = [_piece(vehicle, block, f"{i}", c) for i, block in enumerate(structure.blocks)]
    thrusts = {i: f"x{i}" for i in vehicle.working.tolist()}
    for piece in pieces:
        lines += piece.before
        conditions += piece.conditions
        thrusts |= piece.thrusts
    lines += [f"if (!({' & '.join(conditions)})) {{", "    return INFEASIBLE;", "}"]
    for piece in pieces:
        lines += piece.after
    for i, (low, high) in enumerate(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True)):
        value = f"within({thrusts[i]}, {c(low)}, {c(high)})" if i in thrusts else number(0.0, c.scalar)
        lines.append(f"f[{i}] = {value};")
    return [*lines, "return SOLVED;"]


def _closed_form(vehicle: Vehicle, structure: Structure, c: Table) -> tuple[list[str], list[str]]:
    """Statements of x = G tau for working thrusters, and conditions on tau and on thrusts that no z moves."""
    lines, rows, largest = product(structure.G, "t", c)
    lines += [f"const {c.scalar} x{i} = {signed_sum(rows[i], c.scalar)};" for i in vehicle.working.tolist()]
    # NaN, infinity or overflow in any column makes sum - sum NaN.
    lines.append(f"const {c.scalar} sum = {' + '.join(largest)};")
    more, conditions = reached(structure.unreachable, c)
    slack = _slack(vehicle, c)
    for i in structure.fixed.tolist():
        if vehicle.readiness[i]:
            low, high = float(vehicle.f_min[i] - slack), float(vehicle.f_max[i] + slack)
            conditions.append(between(f"x{i}", low, high, c))
    return lines + more, [f"(sum - sum == {number(0.0, c.scalar)})", *conditions]


def _piece(vehicle: Vehicle, block: Block, name: str, c: Table) -> Piece:
    region = prepare(block.N, _slack(vehicle, c))
    if region.worst_case_steps > STEPS_LIMIT:
        raise NotApplicable(
            f"nullspace@native: each step is written out, here {region.worst_case_steps}, "
            f"more than {STEPS_LIMIT}; use nullspace, or a qp/ method"
        )
    return (_clamp if region.d == 1 else _steps)(vehicle, block, region, name, c)


def _clamp(vehicle: Vehicle, block: Block, region: Region, name: str, c: Table) -> Piece:
    """C of a block of one dimension, without a branch: the slab's lo and hi, and its point nearest to zero.

    Rows with equal scaled limits share the subtraction: lo = limit - (least of their x).
    """
    (slab,) = region.slabs
    lows: dict[float, list[str]] = {}
    highs: dict[float, list[str]] = {}
    thrusts = {}
    for row, scale in slab.members:
        i = int(block.rows[row])
        low, high = sorted((float(vehicle.f_min[i]) * scale, float(vehicle.f_max[i]) * scale))
        x = dot([scale], [f"x{i}"], c)
        lows.setdefault(low, []).append(x)
        highs.setdefault(high, []).append(x)
        thrusts[i] = signed_sum([(False, f"x{i}"), term(1.0 / scale, f"b{name}", c)], c.scalar)
    lo = [f"{c(low)} - {fold('least', xs)}" for low, xs in lows.items()]
    hi = [f"{c(high)} - {fold('most', xs)}" for high, xs in highs.items()]
    lines = [
        f"const {c.scalar} lo{name} = {fold('most', lo)};",
        f"const {c.scalar} hi{name} = {fold('least', hi)};",
        f"const {c.scalar} b{name} = most(lo{name}, least(hi{name}, {number(0.0, c.scalar)}));",
    ]
    return Piece(lines, [f"(lo{name} - hi{name} <= {c(slab.slack)})"], [], thrusts)


def _steps(vehicle: Vehicle, block: Block, region: Region, name: str, c: Table) -> Piece:
    """C of a block of more dimensions: z by Seidel's steps, then the block's thrusts as sums with z."""
    rows = block.rows.tolist()
    limits = [Limits(c(float(vehicle.f_min[i])), c(float(vehicle.f_max[i])), f"x{i}") for i in rows]
    z = names(f"z{name}_", region.d)
    declared = ", ".join(f"{e} = {number(0.0, c.scalar)}" for e in z)
    lines = [f"{c.scalar} {declared};", *nearest(region, limits, z, f"{name}_", c)]
    thrusts = {i: f"x{i} + {dot(row, z, c)}" for i, row in zip(rows, block.N.tolist(), strict=True)}
    return Piece([], [], lines, thrusts)


def _slack(vehicle: Vehicle, c: Table) -> float:
    return TOLERANCE[c.scalar] * vehicle.f_scale
