"""C99 of the exact method for one vehicle: the tables of ``alloc.nullspace`` written out as straight code."""

from itertools import combinations
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import NotApplicable
from alloc.native.bounds import CLimits
from alloc.native.code import (
    TOLERANCE,
    Table,
    defined,
    dot,
    fold,
    names,
    number,
    placed,
    signed_sum,
    term,
)
from alloc.native.entry import (
    Excess,
    SeenArguments,
    closed_form,
    cover,
    infeasible,
    inside,
    lost,
    read,
    refused,
    written,
)
from alloc.native.steps import Strip, joined, nearest
from alloc.nullspace.region import Region, prepare
from alloc.nullspace.structure import Block, Structure, decompose
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import wrench_doubt

STEPS_LIMIT = 500
"""Most steps of a block: each is written out, and more would fill a microcontroller's flash."""


LARGEST_FACTOR = 4.0
"""Most that a thrust which follows from others may move by where one of them moves by one."""


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


def body(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
    """Statements that turn tau into f[0], f[1], … or return with f untouched."""
    structure = decompose(vehicle)
    definitions, excess = lost(structure, c)
    definitions += [*read(vehicle, c), *closed_form(vehicle, structure.G, "t", c), *bounds.definitions()]
    parts = pieces(
        vehicle, structure, max(TOLERANCE[c.scalar], wrench_doubt(vehicle)) * vehicle.f_scale, bounds, c
    )
    seen, lines = SeenArguments(cover(vehicle, structure.G), bounds, c), list[str]()
    for i, piece in enumerate(parts):
        lines += ["fence();"] * (i > 0) + seen.add(piece.rows, f"{i}") + piece.before
        lines += [] if piece.after else inside(piece.thrusts, bounds, c)
        excess += piece.excess
    lines += refused(seen, excess, infeasible(vehicle, bounds, c), c)
    for piece in parts:
        lines += [*piece.after, *inside(piece.thrusts, bounds, c)] if piece.after else []
    return placed(definitions, [*lines, *written(vehicle, c), "return SOLVED;"])


def pieces(
    vehicle: Vehicle, structure: Structure, slack: float, bounds: CLimits, c: Table, zero: str = ""
) -> list[Piece]:
    """The exact answer from x = G tau on, in pieces; nothing is refused where the slack [N] is infinite.

    ``zero`` begins the names of where z is zero, of each block of one dimension, if x is not G tau but any
    thrusts that make tau.
    """
    blocks = [
        _piece(block, slack, f"{i}", bounds, c, zero and f"{zero}{i}")
        for i, block in enumerate(structure.blocks)
    ]
    rows = [i for i in structure.fixed.tolist() if vehicle.readiness[i]]
    excess: Excess = []
    for i in rows if isfinite(slack) else []:
        low, high = bounds.ends(i, wider=slack)
        excess += [(f"{low} - x{i}", 0.0), (f"x{i} - {high}", 0.0)]
    return [*blocks, *([Piece(rows, [], excess, [], {i: f"x{i}" for i in rows})] if rows else [])]


def _piece(block: Block, slack: float, name: str, bounds: CLimits, c: Table, zero: str) -> Piece:
    region = prepare(block.N, slack)
    if region.worst_case_steps > STEPS_LIMIT:
        raise NotApplicable(
            f"generated C: each step is written out, here {region.worst_case_steps}, "
            f"more than {STEPS_LIMIT}; use nullspace, or a qp/ method"
        )
    if region.d == 1:
        return _clamp(block, region, name, bounds, c, zero or number(0.0, c.scalar))
    return _steps(block, region, name, bounds, c)


def _clamp(block: Block, region: Region, name: str, bounds: CLimits, c: Table, zero: str) -> Piece:
    """C of a block of one dimension, without a branch: the slab's lo and hi, and its point nearest to zero.

    Rows with equal scaled limits share the subtraction: lo = limit - (least of their x). Of a row with a
    negative scale the limits change places: lo = (most of their x) - limit.
    """
    (slab,) = region.slabs
    thrusts, lines, excess = dict[int, str](), list[str](), list[tuple[str, float]]()
    nearest, longer = zero, list[tuple[str, str]]()
    for at, alike in enumerate(slab.members):
        lows: dict[tuple[bool, str], list[str]] = {}
        highs: dict[tuple[bool, str], list[str]] = {}
        for row, scale in alike.rows:
            i, minus = int(block.rows[row]), scale < 0
            low, high = bounds.ends(i, abs(scale))[:: -1 if minus else 1]
            x = dot([abs(scale)], [f"x{i}"], c)
            lows.setdefault((minus, low), []).append(x)
            highs.setdefault((minus, high), []).append(x)
            thrusts[i] = signed_sum([(False, f"x{i}"), term(1.0 / scale, f"b{name}", c)], c.scalar)
        lo = [_away(minus, low, fold("most" if minus else "least", xs)) for (minus, low), xs in lows.items()]
        hi = [
            _away(minus, high, fold("least" if minus else "most", xs)) for (minus, high), xs in highs.items()
        ]
        mark = f"{name}_{at}" if at else name
        lines += [defined(f"lo{mark}", fold("most", lo), c), defined(f"hi{mark}", fold("least", hi), c)]
        if isfinite(alike.slack):
            lines.append(defined(f"gap{mark}", f"lo{mark} - hi{mark}", c))
            apart = [f"gap{mark}", *(f"lo{mark} - {most}" for _, most in longer)]
            excess += [
                (each, alike.slack) for each in (*apart, *(f"{least} - hi{mark}" for least, _ in longer))
            ]
        longer.append((f"lo{mark}", f"hi{mark}"))
    for least, most in reversed(longer):  # where they contradict each other the longest have the last word
        nearest = f"most({least}, least({most}, {nearest}))"
    lines.append(defined(f"b{name}", nearest, c))
    return Piece(block.rows.tolist(), lines, excess, [], thrusts)


def _away(minus: bool, limit: str, x: str) -> str:
    """limit - x, or with ``minus`` the opposite; a sum in x stands in brackets."""
    return f"{x} - {limit}" if minus else f"{limit} - {x}"


def _steps(block: Block, region: Region, name: str, bounds: CLimits, c: Table) -> Piece:
    """C of a block of more dimensions: some thrusts by Seidel's steps, the others as sums with those."""
    indices = block.rows.tolist()
    rows = [
        Strip(f"v{i}", normal, f"x{i}", *bounds.ends(i)) for i, normal in zip(indices, block.N, strict=True)
    ]
    lines, slabs = joined(region, rows, f"{name}_", c)
    lines += [f"{c.scalar} {slab.name} = {slab.start};" for slab in slabs if slab.start]
    kept = [slabs[i] for i in _late(np.array([slab.normal for slab in slabs]))]
    lines += nearest(region, slabs, kept, f"{name}_", c)
    moved = names(f"by{name}_", region.d)
    lines += [
        defined(d, f"{row.name} - {row.start}" if row.start else row.name, c)
        for d, row in zip(moved, kept, strict=True)
    ]
    asked = {row.name for row in kept}
    shares = block.N @ np.linalg.inv(np.array([row.normal for row in kept]))
    thrusts = {}
    for i, row, share in zip(indices, rows, shares.tolist(), strict=True):
        terms = [
            (False, f"x{i}"),
            *(term(c.ratio(x), d, c) for x, d in zip(share, moved, strict=True) if c.ratio(x)),
        ]
        thrusts[i] = row.name if row.name in asked else signed_sum(terms, c.scalar)
    return Piece(indices, [], [], lines, thrusts)


def _late(normals: FloatArray) -> list[int]:
    """d slabs (m, d) as late as can be, of which all others are sums without large factors.

    What is late is asked for by the steps anyhow.
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
