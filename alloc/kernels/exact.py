"""The exact method as a program: the tables of ``alloc.nullspace`` written out, block by block."""

from collections.abc import Callable
from itertools import combinations
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.errors import NotApplicable
from alloc.kernels.correction import Gap, limit_gap
from alloc.kernels.entry import (
    Excess,
    SeenArguments,
    all_thrusters,
    clamp_thrusts,
    closed_form,
    cover_arguments,
    lost_parts,
    refine,
    refuse,
)
from alloc.kernels.steps import Ratios, Strip, Values, join_rows, nearest
from alloc.kernels.tolerance import MOVED_ERROR, TOLERANCE, needs_refinement
from alloc.nullspace.region import THIN, Region, prepare
from alloc.nullspace.structure import Block, Structure, decompose
from alloc.program import Builder, Expression, Limits, Number, Program, Scalar, States, Where, least, most
from alloc.program.graph import lifted
from alloc.program.sums import signed, term
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import excess_that_misses, wrench_doubt

STEPS_LIMIT = 500
"""Most steps of a block; each is written out and takes flash."""
LARGEST_FACTOR = 4.0
"""Largest change of a derived thrust per unit change of the thrusts it is derived from [-]."""

THINNER: dict[Scalar, float] = {"double": THIN, "float": 1 / 8}
"""``alloc.nullspace.region.THIN`` of a block of one dimension: thinner rows magnify the rounding of single
precision beyond the error allowed of SOLVED. Blocks of more dimensions keep the order of Python's steps."""


class Piece(NamedTuple):
    """Part of the kernel: the thrusters of a block of the null space, or those that no z moves.

    Attributes
    ----------
    rows : the thrusters
    before : values computed before a demand may be refused; of a block of one dimension the last is its step
        along the normal
    excess : bounds whose excess makes the demand infeasible
    thrusts : adds the steps to the program and returns the thrusts
    branches : True if those steps branch; then they follow the refusals
    gaps : excess of its thrusts over limits; None if only the thrusts show it
    """

    rows: list[int]
    before: list[Expression]
    excess: Excess
    thrusts: Callable[[], dict[int, Expression]]
    branches: bool
    gaps: list[Gap] | None = None


def exact(vehicle: Vehicle, limits: Where, scalar: Scalar, faults: States | None = None) -> Program:
    """Program of the exact optimum, eq. 4-5; raises NotApplicable for too many steps.

    One program serves all ``faults``: a failed thruster has limits of zero.
    """
    builder = Builder(vehicle, limits, scalar, faults)
    structure = decompose(vehicle)
    excess, x = lost_parts(builder, structure), closed_form(builder, structure.G)
    # Moving every thrust by the tolerance may cost twice MOVED_ERROR, lost directions included.
    missed = (1.0 if excess else 2.0) * MOVED_ERROR[scalar]
    doubt = max(TOLERANCE[scalar], wrench_doubt(vehicle)) * vehicle.f_scale
    slack = min(doubt, excess_that_misses(vehicle, missed))
    if needs_refinement(vehicle, scalar):
        x = refine(builder, structure.G, x)
    parts = pieces(builder, structure, x, slack, builder.limits)
    seen, y = SeenArguments(cover_arguments(structure.G), builder), dict[int, Expression]()
    seen.know(0, x)
    for i, part in enumerate(parts):
        if i:
            builder.fence()
        seen.add(part.rows, f"{i}")
        builder.compute(*part.before)
        y |= {} if part.branches else clamp_thrusts(builder, part.thrusts(), builder.limits)
        excess += part.excess
    refuse(builder, seen, excess, exact=True)
    for part in parts:
        y |= clamp_thrusts(builder, part.thrusts(), builder.limits) if part.branches else {}
    return builder.program(all_thrusters(builder, y), Status.SOLVED)


def pieces(
    builder: Builder, structure: Structure, x: dict[int, Expression], slack: float, limits: Limits
) -> list[Piece]:
    """Pieces of the exact answer to x = G tau; an infinite slack [N] refuses nothing."""
    blocks = [piece(builder, f"{b}", block, x, slack, limits) for b, block in enumerate(structure.blocks)]
    rows = [i for i in structure.fixed.tolist() if builder.vehicle.readiness[i]]
    excess: Excess = []
    for i in rows:
        excess += limit_excess(i, x, limits, slack)
    fixed = Piece(rows, [], excess, lambda: {i: x[i] for i in rows}, False)
    return [*blocks, *([fixed] if rows else [])]


def limit_excess(i: int, x: dict[int, Expression], limits: Limits, slack: float) -> Excess:
    """Excess of a thruster that no z moves over its limits widened by the slack; at most zero inside."""
    low, high = limits.ends(i, wider=slack)
    return [(low - x[i], 0.0), (x[i] - high, 0.0)]


def piece(
    builder: Builder,
    name: str,
    block: Block,
    x: dict[int, Expression],
    slack: float,
    limits: Limits,
    zero: Number = 0.0,
) -> Piece:
    """Piece of one block, whose names end in ``name``; an infinite slack [N] refuses nothing.

    ``zero`` is the z of least effort of a block of one dimension, where x makes tau but is not G tau.
    """
    region = prepare(block.N, slack, THINNER[builder.scalar] if block.N.shape[1] == 1 else THIN)
    if region.worst_case_steps > STEPS_LIMIT:
        raise NotApplicable(
            f"generated C: each step is written out, here {region.worst_case_steps}, "
            f"more than {STEPS_LIMIT}; use codegen --library, redistribute, or a qp/ method"
        )
    if region.d == 1:
        return clamp_block(builder, block, region, x, name, limits, zero)
    rows = block.rows.tolist()
    return Piece(rows, [], [], lambda: _steps(builder, block, region, x, name, limits), True)


def clamp_block(
    builder: Builder,
    block: Block,
    region: Region,
    x: dict[int, Expression],
    name: str,
    limits: Limits,
    zero: Number,
) -> Piece:
    """A block of one dimension, without branches: the point of lo … hi nearest to zero.

    Rows with equal scaled limits share the subtraction: lo = limit - (least of their x). A row with a
    negative scale swaps its limits: lo = (most of their x) - limit.
    """
    (slab,) = region.slabs
    before, excess, scales = list[Expression](), Excess(), dict[int, float]()
    gaps = list[Gap]()
    longer, nearest = list[tuple[Expression, Expression]](), zero
    for at, alike in enumerate(slab.members):
        lows: dict[tuple[bool, Number], list[Expression]] = {}
        highs: dict[tuple[bool, Number], list[Expression]] = {}
        for row, scale in alike.rows:
            i, minus = int(block.rows[row]), scale < 0
            low, high = limits.ends(i, abs(scale))[:: -1 if minus else 1]
            scaled = abs(scale) * x[i]
            lows.setdefault((minus, low), []).append(scaled)
            highs.setdefault((minus, high), []).append(scaled)
            scales[i] = scale
        los = [most(*xs) - low if minus else low - least(*xs) for (minus, low), xs in lows.items()]
        his = [least(*xs) - high if minus else high - most(*xs) for (minus, high), xs in highs.items()]
        mark = f"{name}_{at}" if at else name
        lo, hi = most(*los).named(f"lo{mark}"), least(*his).named(f"hi{mark}")
        before += [lo, hi]
        before.append((lo - hi).named(f"gap{mark}"))
        apart = [before[-1], *(lo - upper for _, upper in longer), *(lower - hi for lower, _ in longer)]
        gaps += [Gap(each, {int(block.rows[row]): 1.0 / abs(s) for row, s in alike.rows}) for each in apart]
        if isfinite(alike.slack):
            excess += [(each, alike.slack) for each in apart]
        longer.append((lo, hi))
    for lo, hi in reversed(longer):  # the longest row decides between contradicting rows
        nearest = most(lo, least(hi, nearest))
    b = lifted(nearest, longer[0][0].graph).named(f"b{name}")
    before.append(b)
    thrusts = {i: signed([(False, x[i]), term(1.0 / scale, b)]) for i, scale in scales.items()}
    for row in region.checks:  # z moves these by less than rounding
        i, by = int(block.rows[row]), float(block.N[row, 0] / slab.normal[0])
        thrusts[i] = signed([(False, x[i]), *([term(by, b)] if by else [])])
        gaps.append(limit_gap(builder, i, thrusts[i], limits))
        if isfinite(region.tolerance):
            excess += limit_excess(i, x, limits, region.tolerance)
    return Piece(block.rows.tolist(), before, excess, lambda: thrusts, False, gaps)


def _steps(
    builder: Builder, block: Block, region: Region, x: dict[int, Expression], name: str, limits: Limits
) -> dict[int, Expression]:
    """A block of more dimensions: d thrusts by Seidel's steps, the others as sums of these."""
    indices, ratios = block.rows.tolist(), Ratios()
    rows = [Strip(f"v{i}", normal, x[i], *limits.ends(i)) for i, normal in zip(indices, block.N, strict=True)]
    values: Values = {row.key: x[i] for row, i in zip(rows, indices, strict=True)}
    kept, moved = moves(builder, region, rows, values, name, ratios)
    asked = {row.key for row in kept}
    shares = block.N @ np.linalg.inv(np.array([row.normal for row in kept]))
    thrusts = {}
    for i, row, share in zip(indices, rows, shares.tolist(), strict=True):
        terms = [
            (False, x[i]),
            *(term(ratios(s), by) for s, by in zip(share, moved, strict=True) if ratios(s)),
        ]
        thrusts[i] = values[row.key] if row.key in asked else signed(terms)
    return thrusts


def moves(
    builder: Builder, region: Region, rows: list[Strip], values: Values, name: str, ratios: Ratios
) -> tuple[list[Strip], list[Expression]]:
    """Take Seidel's steps: d rows from which all others follow, and how far each of these has moved."""
    slabs = join_rows(builder, region, rows, values, f"{name}_")
    builder.compute(*(slab.start for slab in slabs if slab.start is not None))
    kept = [slabs[i] for i in _late(np.array([slab.normal for slab in slabs]))]
    nearest(builder, region, slabs, kept, values, f"{name}_", ratios)
    moved = [
        (values[row.key] if row.start is None else values[row.key] - row.start).named(f"by{name}_{j}")
        for j, row in enumerate(kept)
    ]
    builder.compute(*moved)
    return kept, moved


def _late(normals: FloatArray) -> list[int]:
    """The last d slabs of normals (m, d) from which the others follow without large factors.

    The steps compute late slabs anyhow.
    """
    m, d = normals.shape
    choices = [list(choice) for choice in combinations(reversed(range(m)), d)]
    factors = [_largest(normals, choice) for choice in choices]
    good = [choice for choice, factor in zip(choices, factors, strict=True) if factor <= LARGEST_FACTOR]
    return good[0] if good else choices[int(np.argmin(factors))]


def _largest(normals: FloatArray, choice: list[int]) -> float:
    chosen = normals[choice]
    if np.linalg.matrix_rank(chosen) < len(choice):
        return inf
    return float(np.abs(normals @ np.linalg.inv(chosen)).max())
