"""C99 of the methods that go level by level towards a demand, and give the least effort where the way ends.

What ``alloc.reach.way`` takes out of tables stands here as straight code: each facet is a few sums.
"""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np

from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.errors import NotApplicable
from alloc.formulations import Formulation
from alloc.native.bounds import CLimits
from alloc.native.code import (
    Scalar,
    Table,
    Terms,
    butterflies,
    defined,
    fold,
    gathered,
    names,
    number,
    placed,
    product,
    signed_sum,
    snapped,
    term,
)
from alloc.native.entry import closed_form, crossed, entered, inside, read, refused, written
from alloc.native.exact import pieces
from alloc.nullspace.structure import decompose
from alloc.reach import edge as facets
from alloc.reach.levels import step_maps
from alloc.reach.way import Way
from alloc.reach.zonotope import ROUNDING
from alloc.vehicle import Vehicle

FACETS_LIMIT = 300
"""Most pairs of facets: each is written out, and more would fill a microcontroller's flash."""
PARALLEL: dict[Scalar, float] = {"double": facets.PARALLEL, "float": 2e-6}
EDGE: dict[Scalar, float] = {"double": facets.EDGE, "float": 4e-6}
"""What ``alloc.reach.edge`` has for double, and what rounding makes of it in float."""
ROOMY = 1e-3
"""Where a facet leaves more room than this in unit of ``wrench_scale``, rounding of a step along it is
nothing to it."""


Room = str | float
"""What is left along a facet's normal [N of the thruster that pushes most along it]: C name, or number."""


class CDeparture(NamedTuple):
    """Where a way begins, in C.

    Attributes
    ----------
    definitions : of what the others name
    wrench : of each axis, the term w = (T P f0) [N, N m]; None where it is zero
    rooms : of each pair of facets, the room along the normal and along its opposite
    """

    definitions: list[str]
    wrench: list[tuple[bool, str] | None]
    rooms: list[tuple[Room, Room]]


def _fixed(way: Way, vehicle: Vehicle, longest: FloatArray, c: Table) -> CDeparture:
    """The departure within the vehicle's limits: all of it is known beforehand."""
    begin = way.departure(vehicle.f_min, vehicle.f_max)
    rooms = begin.room.reshape(2, -1) / longest
    wrench = [(w < 0, c(abs(w))) if w else None for w in begin.wrench.tolist()]
    return CDeparture([], wrench, list(zip(*rooms.tolist(), strict=True)))


def _at_call(vehicle: Vehicle, table: FloatArray, c: Table) -> CDeparture:
    """The departure within the limits of the call: f0, then g from there to the limits, w, and the rooms."""
    zero, inset, n = number(0.0, c.scalar), c(facets.INSET), vehicle.n
    definitions: list[str] = []
    for i in vehicle.working.tolist():
        definitions += [
            defined(f"near{i}", f"within({zero}, l{i}, h{i})", c),
            defined(f"in{i}", f"o{i} * {inset}", c),
            defined(f"f{i}", f"near{i} + within(near{i}, in{i}, -in{i})", c),
            defined(f"g{i}", f"h{i} - f{i}", c),
            defined(f"g{n + i}", f"f{i} - l{i}", c),
        ]
    lines, rows, _ = product(table, "g", c, "proom")
    sums, rows = butterflies(rows, c, "sroom")
    more, wrench = gathered(vehicle.TP, "f", c, "sw_")
    definitions += [*lines, *sums, *more]
    for name, each in (("room", rows), ("w_", wrench)):
        definitions += [defined(f"{name}{r}", signed_sum(row, c.scalar), c) for r, row in enumerate(each)]
    half = len(table) // 2
    rooms: list[tuple[Room, Room]] = [(f"room{m}", f"room{half + m}") for m in range(half)]
    return CDeparture(definitions, [(False, f"w_{r}") for r in range(vehicle.k)], rooms)


class Walk:
    """The C of one way, written level by level.

    Attributes
    ----------
    definitions : of all that statements may need
    statements : the share of each level, and what it leaves
    """

    def __init__(self, vehicle: Vehicle, way: Way, bounds: CLimits, c: Table) -> None:
        """Write the way; raises NotApplicable where there are too many facets to write them out."""
        found = facets.edge(vehicle)
        if len(found.normals) > FACETS_LIMIT:
            raise NotApplicable(
                f"generated C: each facet is written out, here {len(found.normals)} pairs, more than "
                f"{FACETS_LIMIT}; use the method in Python"
            )
        self._c, self._k, self._scale = c, vehicle.k, found.scale
        # Normals are stretched until the thruster that pushes most along one does so by one newton a newton:
        # on many vehicles the room along a facet is then a plain sum.
        self._longest = snapped(np.abs(found.push).max(axis=1))
        self._normals = found.normals / self._longest[:, None]
        if bounds.at_call:
            begin = _at_call(vehicle, facets.room_table(found) / np.tile(self._longest, 2)[:, None], c)
        else:
            begin = _fixed(way, vehicle, self._longest, c)
        self._rooms = begin.rooms
        self.definitions = list(begin.definitions)
        self.statements: list[str] = []
        ends: list[Terms] = [[w] if w else [] for w in begin.wrench]
        for r, w in enumerate(begin.wrench):
            away: Terms = [(False, f"t{r}"), *([(not w[0], w[1])] if w else [])]
            self.definitions.append(defined(f"n0_{r}", signed_sum(away, c.scalar), c))
        maps = step_maps(vehicle, way.levels)
        for level, (D, keep) in enumerate(zip(maps, way.keep, strict=True)):
            steps = self._step(level, D, keep, maps[level + 1 :])
            for r, step in steps.items():
                ends[r].append((False, f"share{level} * {step}"))
        for r, end in enumerate(ends):
            self.definitions.append(defined(f"e{r}", signed_sum(end, c.scalar), c))

    def _step(self, level: int, D: FloatArray, keep: float, later: FloatArray) -> dict[int, str]:
        """The share of one level and what is left to later ones; returns the step on each axis that moves."""
        c, T = self._c, self._c.scalar
        steps: dict[int, str] = {}
        for r, row in enumerate(D):
            moving = np.flatnonzero(row)
            if len(moving) == 1 and row[moving[0]] == 1.0:
                steps[r] = f"n{level}_{moving[0]}"
            elif len(moving):
                terms = [term(float(row[j]), f"n{level}_{j}", c) for j in moving]
                self.definitions.append(defined(f"d{level}_{r}", signed_sum(terms, T), c))
                steps[r] = f"d{level}_{r}"
        along = self._normals @ D
        along[self._sizes(along) <= ROUNDING] = 0.0
        lines, rows, _ = product(along, f"n{level}_", c, f"pa{level}_")
        sums, rows = butterflies(rows, c, f"sa{level}_")
        self.definitions += [*lines, *sums]
        used = [m for m, row in enumerate(rows) if row]
        self.definitions += [defined(f"a{level}_{m}", signed_sum(rows[m], T), c) for m in used]
        sizes = [f"size({c(1.0 / self._scale[r])} * {step})" for r, step in steps.items()]
        self.definitions.append(defined(f"size{level}", fold("most", sizes) if sizes else number(0.0, T), c))
        for i, longest in enumerate(np.unique(self._longest).tolist()):
            tiny = f"{c(PARALLEL[T] / longest)} * size{level}"
            self.definitions.append(defined(f"tiny{level}_{i}", tiny, c))
        kept = most = c(keep)
        for m in used:
            # One after the other: all at once would need more registers than a processor has.
            self.statements.append(defined(f"load{level}_{m}", f"most({self._load(level, m)}, {most})", c))
            most = f"load{level}_{m}"
        self.statements.append(defined(f"share{level}", f"rounded({kept} / {most}, {c(1.0 - EDGE[T])})", c))
        if len(later):
            reach = self._sizes(self._normals @ later).max(axis=(0, 2)) > ROUNDING
            self._leave(level, [m for m in used if reach[m]], steps, np.abs(later).max(axis=(0, 1)) > 0)
        return steps

    def _sizes(self, along: FloatArray) -> FloatArray:
        """Entries of normals times steps (…, M, k), relative to a normal's length, in ``wrench_scale``."""
        relative: FloatArray = np.abs(along) * self._longest[:, None] * self._scale
        return relative

    def _load(self, level: int, m: int) -> str:
        """What the step takes of the room that it has along a facet's normal, or along its opposite."""
        ahead, astern = self._rooms[m]
        along = f"a{level}_{m}"
        if isinstance(ahead, float) and isinstance(astern, float) and self._roomy(m, ahead, astern):
            if ahead == astern:
                return f"size({along} * {self._c(1.0 / ahead)})"
            return f"most({along} * {self._c(1.0 / ahead)}, -{along} * {self._c(1.0 / astern)})"
        tiny = int(np.searchsorted(np.unique(self._longest), self._longest[m]))
        return f"load({along}, {self._text(ahead)}, {self._text(astern)}, tiny{level}_{tiny})"

    def _roomy(self, m: int, ahead: float, astern: float) -> bool:
        return min(ahead, astern) * float(self._longest[m]) > ROOMY

    def _leave(self, level: int, left: list[int], steps: dict[int, str], needed: BoolArray) -> None:
        """Definitions of the rooms and of what is missing after a level."""
        c, zero = self._c, number(0.0, self._c.scalar)
        for m in left:
            ahead, astern = map(self._text, self._rooms[m])
            taken = f"share{level} * a{level}_{m}"
            self.definitions += [
                defined(f"ahead{level}_{m}", f"most({ahead} - {taken}, {zero})", c),
                defined(f"astern{level}_{m}", f"most({astern} + {taken}, {zero})", c),
            ]
            self._rooms[m] = (f"ahead{level}_{m}", f"astern{level}_{m}")
        for r in range(self._k):
            done = f" - share{level} * {steps[r]}" if r in steps and needed[r] else ""
            self.definitions.append(defined(f"n{level + 1}_{r}", f"n{level}_{r}{done}", c))

    def _text(self, room: Room) -> str:
        return self._c(room) if isinstance(room, float) else room


def by_level(formulation: Formulation) -> Callable[[Vehicle, CLimits, Table], list[str]]:
    """The statements of the method that answers this formulation."""
    assert formulation.way is not None
    way_of = formulation.way

    def statements(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
        way, structure = way_of(vehicle), decompose(vehicle)
        walk = Walk(vehicle, way, bounds, c)
        definitions = [*read(vehicle, c), *bounds.definitions(), *walk.definitions]
        definitions += closed_form(vehicle, structure.G, "e", c)
        working = vehicle.working.tolist() if bounds.at_call else []
        lines, excess = entered(working, names("t", vehicle.k), "0", bounds, c)
        lines += refused(["s0"], excess, crossed(bounds, c), c)
        lines += walk.statements
        for piece in pieces(vehicle, structure, inf, bounds, c):
            lines += [*piece.before, *piece.after, *inside(piece.thrusts, bounds, c)]
        lines += written(vehicle, c)
        levels = names("share", len(way.keep))
        lines += [f"share[{i}] = {name};" for i, name in enumerate(levels)]
        more, met = _met(structure.unreachable, levels, c)
        return placed([*definitions, *more], [*lines, f"return {met} ? SOLVED : PARTIAL;"])

    return statements


def _met(lost: FloatArray, levels: list[str], c: Table) -> tuple[list[str], str]:
    """Definitions and the condition that all of tau is delivered, also what no thruster pushes."""
    one = number(1.0, c.scalar)
    whole = f"{fold('least', levels)} >= {one}"
    if not len(lost):
        return [], whole
    # In unit of wrench_scale the rows are orthonormal, so their squares add up to that of what is missing.
    lines, rows, _ = product(lost / WRENCH_TOLERANCE, "t", c, "pm")
    missed = [defined(f"missed{i}", signed_sum(row, c.scalar), c) for i, row in enumerate(rows)]
    squares = " + ".join(f"missed{i} * missed{i}" for i in range(len(rows)))
    return [*lines, *missed], f"{whole} && {squares} <= {one}"
