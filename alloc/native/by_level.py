"""C99 of methods that go level by level towards a demand, and give the least effort where the way ends."""

from collections.abc import Callable
from math import inf

import numpy as np

from alloc.allocation import FloatArray
from alloc.formulations import Formulation
from alloc.native.bounds import CLimits
from alloc.native.code import (
    MET,
    Table,
    Terms,
    Value,
    defined,
    expression,
    fold,
    gathered,
    names,
    number,
    placed,
    product,
    signed_sum,
)
from alloc.native.entry import crossed, inside, read, refused
from alloc.native.exact import pieces
from alloc.native.walk import Walk
from alloc.nullspace.region import leading
from alloc.nullspace.structure import Structure, decompose
from alloc.vehicle import Vehicle


def by_level(formulation: Formulation) -> Callable[[Vehicle, CLimits, Table], list[str]]:
    """The statements of the method that answers this formulation."""
    assert formulation.way is not None
    way_of = formulation.way

    def statements(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
        structure, again = decompose(vehicle), bounds.again("e")
        walk = Walk(vehicle, way_of(vehicle), structure.G, bounds, c)
        # Thrusts that are products with G alone have nothing in the null space.
        resting = walk.starts_at_rest
        definitions = [*read(vehicle, c), *bounds.definitions(), *again.definitions(), *walk.definitions]
        definitions += _ends(vehicle, structure, walk.f, resting, c)
        last = len(walk.statements) - 1
        early, late = list[str](), refused(walk.seen, [], crossed(bounds, c), c)
        ready = pieces(vehicle, structure, inf, again, c, "" if resting else "z")
        for level, lines in enumerate(walk.statements):
            early += lines
            for piece in (piece for piece in ready if walk.arrived(piece.rows) == level):
                # What no later level moves is ended here, and written where nothing is refused any more.
                answer = late if level == last else early
                answer += ["fence();"] * bounds.at_call
                answer += [*piece.before, *piece.after, *inside(piece.thrusts, again, c)]
                late += [f"f[{i}] = y{i};" for i in piece.thrusts]
        late += [f"f[{i}] = {number(0.0, c.scalar)};" for i in np.flatnonzero(vehicle.readiness == 0)]
        shares = names("share", len(walk.statements))
        late += [f"share[{level}] = {name};" for level, name in enumerate(shares)]
        more, met = _met(structure.unreachable, shares, c)
        return placed([*definitions, *more], [*early, *late, f"return {met} ? SOLVED : PARTIAL;"])

    return statements


def _ends(vehicle: Vehicle, structure: Structure, f: list[Value], resting: bool, c: Table) -> list[str]:
    """Definitions of x, thrusts f without what they have in the null space.

    Of a block of one dimension x is f, and z says where it would be without. ``resting`` says that f has
    nothing there.
    """
    rows: dict[int, Terms] = {i: [] for i in vehicle.working.tolist()}
    definitions = []
    for b, block in enumerate(() if resting else structure.blocks):
        # N in unit of its slab, or so that zero entries stay zero and equal sizes become one.
        N = block.N / (np.abs(block.N).max(axis=0) if block.N.shape[1] > 1 else leading(block.N))
        # A full H also couples what z moves with thrusters that it doesn't.
        NtH = np.where(vehicle.readiness > 0, N.T @ vehicle.H[block.rows], 0.0)
        wide = -np.linalg.solve(NtH[:, block.rows] @ N, NtH)
        lines, inner = gathered(wide, "r", c, f"sz{b}_")
        z = names(f"z{b}_", N.shape[1]) if N.shape[1] > 1 else [f"z{b}"]
        definitions += lines
        definitions += [
            defined(name, signed_sum(row, c.scalar), c) for name, row in zip(z, inner, strict=True)
        ]
        if N.shape[1] > 1:
            lines, outer, _ = product(N, f"z{b}_", c, f"pz{b}_")
            definitions += lines
            rows |= dict(zip(block.rows.tolist(), outer, strict=True))
    for i in rows:
        definitions += [
            defined(f"r{i}", expression(f[i], c), c),
            defined(f"x{i}", signed_sum([(False, f"r{i}"), *rows[i]], c.scalar), c),
        ]
    return definitions


def _met(lost: FloatArray, levels: list[str], c: Table) -> tuple[list[str], str]:
    """Definitions and the condition that all of tau is delivered, also what no thruster pushes."""
    one = number(1.0, c.scalar)
    whole = f"{fold('least', levels)} >= {one}"
    if not len(lost):
        return [], whole
    # In unit of wrench_scale the rows are orthonormal, so their squares add up to that of what is missing.
    lines, rows, _ = product(lost / MET[c.scalar], "t", c, "pm")
    missed = [defined(f"missed{i}", signed_sum(row, c.scalar), c) for i, row in enumerate(rows)]
    squares = " + ".join(f"missed{i} * missed{i}" for i in range(len(rows)))
    return [*lines, *missed], f"{whole} && {squares} <= {one}"
