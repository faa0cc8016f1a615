"""C99 of the exact method for one vehicle: the tables of ``alloc.nullspace`` written out as straight code."""

from typing import NamedTuple

from alloc.errors import NotApplicable
from alloc.native.bounds import Bounds
from alloc.native.code import TOLERANCE, Table, defined, dot, fold, names, number, placed, signed_sum, term
from alloc.native.entry import Excess, closed_form, cover, entered, infeasible, inside, lost, refused, written
from alloc.native.steps import Limits, nearest
from alloc.nullspace.region import Region, prepare
from alloc.nullspace.structure import Block, Structure, decompose
from alloc.vehicle import Vehicle

STEPS_LIMIT = 500
"""Most steps of a block: each is written out, and more would fill a microcontroller's flash."""


class Piece(NamedTuple):
    """What one part of the thrusters adds to the kernel: a block of the null space, or those that no z moves.

    Attributes
    ----------
    rows : the thrusters
    before : statements that what may be exceeded needs
    excess : what must not be exceeded, or the demand is infeasible
    after : statements for a demand that exceeds nothing in any block
    thrusts : C expression of the thrust of each thruster
    """

    rows: list[int]
    before: list[str]
    excess: Excess
    after: list[str]
    thrusts: dict[int, str]


def body(vehicle: Vehicle, bounds: Bounds, c: Table) -> list[str]:
    """Statements that turn tau into f[0], f[1], … or return with f untouched."""
    structure = decompose(vehicle)
    definitions, excess = lost(structure, c)
    definitions += [*closed_form(vehicle, structure.G, c), *bounds.definitions()]
    pieces = [
        *(_piece(block, _slack(vehicle, c), f"{i}", bounds, c) for i, block in enumerate(structure.blocks)),
        *_fixed(vehicle, structure, bounds, c),
    ]
    unseen, lines = cover(vehicle, structure.G), []
    for i, piece in enumerate(pieces):
        crossing, seen = entered(piece.rows, unseen, f"{i}", bounds, c)
        lines += ["fence();"] * (i > 0) + crossing + piece.before
        lines += [] if piece.after else inside(piece.thrusts, bounds, c)
        excess += [*seen, *piece.excess]
    sums = [*names("s", len(pieces)), *unseen]
    lines += refused(sums, excess, infeasible(vehicle, bounds, c), c)
    for piece in pieces:
        lines += [*piece.after, *inside(piece.thrusts, bounds, c)] if piece.after else []
    return placed(definitions, [*lines, *written(vehicle, c), "return SOLVED;"])


def _fixed(vehicle: Vehicle, structure: Structure, bounds: Bounds, c: Table) -> list[Piece]:
    """The thrusts that no z moves, if there are any: they lie within their limits and the slack, or none do."""
    rows = [i for i in structure.fixed.tolist() if vehicle.readiness[i]]
    excess: Excess = []
    for i in rows:
        low, high = bounds.ends(i, wider=_slack(vehicle, c))
        excess += [(f"{low} - x{i}", 0.0), (f"x{i} - {high}", 0.0)]
    return [Piece(rows, [], excess, [], {i: f"x{i}" for i in rows})] if rows else []


def _piece(block: Block, slack: float, name: str, bounds: Bounds, c: Table) -> Piece:
    region = prepare(block.N, slack)
    if region.worst_case_steps > STEPS_LIMIT:
        raise NotApplicable(
            f"nullspace@native: each step is written out, here {region.worst_case_steps}, "
            f"more than {STEPS_LIMIT}; use nullspace, or a qp/ method"
        )
    return (_clamp if region.d == 1 else _steps)(block, region, name, bounds, c)


def _clamp(block: Block, region: Region, name: str, bounds: Bounds, c: Table) -> Piece:
    """C of a block of one dimension, without a branch: the slab's lo and hi, and its point nearest to zero.

    Rows with equal scaled limits share the subtraction: lo = limit - (least of their x). Of a row with a
    negative scale the limits change places: lo = (most of their x) - limit.
    """
    (slab,) = region.slabs
    lows: dict[tuple[bool, str], list[str]] = {}
    highs: dict[tuple[bool, str], list[str]] = {}
    thrusts = {}
    for row, scale in slab.members:
        i, minus = int(block.rows[row]), scale < 0
        low, high = bounds.ends(i, abs(scale))[:: -1 if minus else 1]
        x = dot([abs(scale)], [f"x{i}"], c)
        lows.setdefault((minus, low), []).append(x)
        highs.setdefault((minus, high), []).append(x)
        thrusts[i] = signed_sum([(False, f"x{i}"), term(1.0 / scale, f"b{name}", c)], c.scalar)
    lo = [_away(minus, low, fold("most" if minus else "least", xs)) for (minus, low), xs in lows.items()]
    hi = [_away(minus, high, fold("least" if minus else "most", xs)) for (minus, high), xs in highs.items()]
    lines = [
        defined(f"lo{name}", fold("most", lo), c),
        defined(f"hi{name}", fold("least", hi), c),
        defined(f"gap{name}", f"lo{name} - hi{name}", c),
        defined(f"b{name}", f"most(lo{name}, least(hi{name}, {number(0.0, c.scalar)}))", c),
    ]
    return Piece(block.rows.tolist(), lines, [(f"gap{name}", slab.slack)], [], thrusts)


def _away(minus: bool, limit: str, x: str) -> str:
    """limit - x, or with ``minus`` the opposite; a sum in x stands in brackets."""
    return f"{x} - {limit}" if minus else f"{limit} - {x}"


def _steps(block: Block, region: Region, name: str, bounds: Bounds, c: Table) -> Piece:
    """C of a block of more dimensions: z by Seidel's steps, then the block's thrusts as sums with z."""
    rows = block.rows.tolist()
    limits = [Limits(*bounds.ends(i), f"x{i}") for i in rows]
    z = names(f"z{name}_", region.d)
    declared = ", ".join(f"{e} = {number(0.0, c.scalar)}" for e in z)
    lines = [f"{c.scalar} {declared};", *nearest(region, limits, z, f"{name}_", c)]
    thrusts = {i: f"x{i} + {dot(row, z, c)}" for i, row in zip(rows, block.N.tolist(), strict=True)}
    return Piece(rows, [], [], lines, thrusts)


def _slack(vehicle: Vehicle, c: Table) -> float:
    return TOLERANCE[c.scalar] * vehicle.f_scale
