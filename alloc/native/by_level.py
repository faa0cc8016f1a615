"""C99 of the methods that go level by level towards a demand, and give the least effort where the way ends.

What ``alloc.reach.way`` takes out of tables stands here as straight code: each facet is a few sums.
"""

from collections.abc import Callable, Sequence
from math import inf

import numpy as np

from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.errors import NotApplicable
from alloc.formulations import Formulation
from alloc.native.bounds import CLimits
from alloc.native.code import (
    MET,
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
from alloc.native.entry import Excess, cover, crossed, entered, inside, read, refused
from alloc.native.exact import pieces
from alloc.nullspace.structure import Structure, decompose
from alloc.reach import edge as facets
from alloc.reach.levels import groups, step_maps
from alloc.reach.way import Way
from alloc.reach.zonotope import ROUNDING
from alloc.vehicle import Vehicle

FACETS_LIMIT = 300
"""Most pairs of facets: each is written out, and more would fill a microcontroller's flash."""
PARALLEL: dict[Scalar, float] = {"double": facets.PARALLEL, "float": 2e-6}
EDGE: dict[Scalar, float] = {"double": facets.EDGE, "float": 4e-6}
"""What ``alloc.reach.edge`` has for double, and what rounding makes of it in float."""
ROOMY = 1e-3
"""Where a facet leaves more room than this share of the largest limit, rounding of a step along it is nothing
to it."""


Value = str | float
"""A C name, or a number that is known beforehand."""


class Walk:
    """The C of one way, written level by level, in thrusts.

    On the way only the wrench T f counts, so f may lie beyond limits: a step of the wrench is any d with T d
    that step, and the room along a facet is a sum over thrusters of what lies between f and a limit. At the
    end what f has in the null space is taken out.

    Attributes
    ----------
    definitions : of all that statements may need; at the end x, what G makes of the wrench that is reached
    statements : the share of each level
    resting : whether the way begins without thrust
    sums, excess : what is finite, and what at most zero, only if the arguments are good
    """

    def __init__(self, vehicle: Vehicle, way: Way, structure: Structure, bounds: CLimits, c: Table) -> None:
        """Write the way; raises NotApplicable where there are too many facets to write them out."""
        found = facets.edge(vehicle)
        if len(found.normals) > FACETS_LIMIT:
            raise NotApplicable(
                f"generated C: each facet is written out, here {len(found.normals)} pairs, more than "
                f"{FACETS_LIMIT}; use the method in Python"
            )
        self._vehicle, self._bounds, self._c = vehicle, bounds, c
        self._G = structure.G
        # Normals are stretched until the thruster that pushes most along one does so by one newton a newton:
        # on many vehicles the room along a facet is then a plain sum.
        self._push = snapped(found.push / np.abs(found.push).max(axis=1)[:, None])
        self._parts = components(self._push != 0)
        self._normals = found.normals * found.scale
        self._scale = found.scale
        self._rooms: dict[int, tuple[Value, Value]] = {}
        self._sums: dict[str, list[str]] = {}
        self._tiny: dict[tuple[int, int], str] = {}
        self._gaps: dict[int, tuple[str, str]] = {}
        self._last = -1
        self.ends: list[tuple[int, list[int]]] = []
        self.sums: list[str] = []
        self._entered: set[int] = set()
        self.excess: Excess = []
        self._whole = _whole(vehicle, way)
        self._maps = step_maps(vehicle, way.levels)
        self._unseen = self._cover()
        self.definitions: list[str] = []
        self.statements: list[str] = []
        self._f: list[Value] = self._start()
        # Of the thrusts that the way begins with; several levels take them through T and G.
        known = [abs(f) for f in self._f if isinstance(f, float)]
        through = (
            float((np.abs(structure.G) @ np.abs(vehicle.TP)).sum(axis=1).max()) if way.levels[1:] else 1.0
        )
        self._size = max(1.0, through) * (vehicle.f_scale if bounds.at_call else max(known))
        self.resting = all(f == 0.0 for f in self._f)
        for level, (D, keep) in enumerate(zip(self._maps, way.keep, strict=True)):
            self._level = level
            moved = self._step(level, D, last=level + 1 == len(self._maps))
            self._stop(level, D, keep, moved)
            self._move(level, moved)
            self._leave()
            self.ends.append((len(self.statements), moved))
        self._end(structure)
        self._enter(sorted(set(vehicle.working.tolist()) - self._entered), "left")
        self.sums += self._unseen

    def arrived(self, rows: list[int]) -> int:
        """Behind how many statements these thrusters move no more."""
        ends = [end for end, moved in self.ends if not {*rows}.isdisjoint(moved)]
        return ends[-1] if ends else self.ends[-1][0]

    def _cover(self) -> list[str]:
        """Few steps of thrusts, of any level, and entries of tau, in which every entry of tau appears."""
        found, rest = list[str](), np.ones(self._vehicle.k, dtype=bool)
        for level, D in enumerate(self._maps):
            into = self._G @ D if len(self._maps) > 1 else self._G
            found += [x for x in cover(self._vehicle, into * rest, f"d{level}_") if x.startswith("d")]
            rest &= ~snapped(into).any(axis=0)
        return [*found, *(f"t{j}" for j in np.flatnonzero(rest))]

    def _arrive(self, j: int) -> None:
        """Statements where facets of part j come: the first time, that its arguments enter."""
        if j == self._last:
            return
        self._leave()
        if self._last >= 0 and self._bounds.at_call:
            self.statements.append("fence();")
        self._last = j

    def _leave(self) -> None:
        if self._last < 0:
            return
        rows = np.flatnonzero(self._push[self._parts[self._last]].any(axis=0)).tolist()
        if not self._entered.issuperset(rows):
            self._enter(rows, f"{self._last}")

    def _enter(self, rows: list[int], name: str) -> None:
        if not rows:
            return
        steps = [f"d{level}_" for level in range(self._level + 1)]
        lines, excess = entered(rows, self._unseen, name, self._bounds, self._c, steps)
        self.statements += lines
        self.excess += excess
        self.sums.append(f"s{name}")
        self._entered |= set(rows)

    def _start(self) -> list[Value]:
        """Thrusts f0: zero where the limits allow it, else a little inside the end nearest to it."""
        vehicle, c, zero = self._vehicle, self._c, number(0.0, self._c.scalar)
        if not self._bounds.at_call:
            return list(np.where(vehicle.readiness > 0, facets.start(vehicle.f_min, vehicle.f_max), 0.0))
        for i in vehicle.working.tolist():
            low, high = self._bounds.ends(i)
            self.definitions += [
                defined(f"near{i}", f"within({zero}, {low}, {high})", c),
                defined(f"in{i}", f"o{i} * {c(facets.INSET)}", c),
                defined(f"f{i}", f"near{i} + within(near{i}, in{i}, -in{i})", c),
            ]
        return [f"f{i}" if ready else 0.0 for i, ready in enumerate(vehicle.readiness)]

    def _step(self, level: int, D: FloatArray, *, last: bool) -> list[int]:
        """Definitions of d, thrusts that make the level's step; returns the thrusters that it moves."""
        c, T, vehicle = self._c, self._c.scalar, self._vehicle
        whole = self._whole[level]
        taken: list[Value] = [0.0] * vehicle.n
        for i in np.flatnonzero(vehicle.TP[whole].any(axis=0)):
            taken[i] = self._f[i]
        self.definitions += [defined(f"m{level}_{r}", f"t{r}", c) for r in np.flatnonzero(whole)]
        if not level and not whole.all():
            self._missing()
        for r in np.flatnonzero(~whole):
            terms = [term(float(D[r, j]), f"n{level}_{j}", c) for j in np.flatnonzero(D[r])]
            self.definitions.append(defined(f"m{level}_{r}", signed_sum(terms, T), c))
            if not last:
                rest = f"n{level}_{r}" + (f" - part{level} * m{level}_{r}" if terms else "")
                self.definitions.append(defined(f"n{level + 1}_{r}", rest, c))
        matrix = np.where(D.any(axis=1) | whole, self._G, 0.0)
        lines, rows, largest = product(matrix, f"m{level}_", c, f"pd{level}_")
        self._products = rows
        sums, rows = butterflies(rows, c, f"sd{level}_")
        self.definitions += [*lines, *sums]
        moved = [i for i in vehicle.working.tolist() if rows[i]]
        for j, part in enumerate(self._parts):
            pushing = self._push[part].any(axis=0)
            sizes = [f"size({largest[r]})" for r in np.flatnonzero(snapped(matrix)[pushing].any(axis=0))]
            if len(sizes) == 1 and not any(taken[i] != 0.0 for i in np.flatnonzero(pushing)):
                sizes = []  # what goes along one product alone is never tiny beside it
            sizes += [c(self._size)] if self._size else []
            if sizes:
                self._tiny[level, j] = f"tiny{level}_{j}"
                tiny = f"{c(PARALLEL[T])} * {fold('most', sizes)}"
                self.definitions.append(defined(f"tiny{level}_{j}", tiny, c))
        for i in moved:
            away: Terms = [(True, self._text(taken[i]))] if taken[i] != 0.0 else []
            self._products[i] = [] if away else self._products[i]
            self.definitions.append(defined(f"d{level}_{i}", signed_sum([*rows[i], *away], T), c))
        return moved

    def _missing(self) -> None:
        """Definitions of n = tau - T f0."""
        c = self._c
        f0 = self._vehicle.TP @ [f if isinstance(f, float) else 0.0 for f in self._f]
        lines, rows = gathered(self._vehicle.TP, "f", c, "w") if self._bounds.at_call else ([], [])
        self.definitions += lines
        for r, known in enumerate(f0.tolist()):
            away = [(known < 0, c(abs(known)))] if known else []
            terms = [(False, f"t{r}"), *((not minus, text) for minus, text in (rows[r] if rows else away))]
            self.definitions.append(defined(f"n0_{r}", signed_sum(terms, c.scalar), c))

    def _stop(self, level: int, D: FloatArray, keep: float, moved: list[int]) -> None:
        """Statements of the level's share: the least that a facet's room leaves of the step."""
        c, T = self._c, self._c.scalar
        along = np.abs(self._normals @ (D * (self._scale / self._scale[:, None])))
        used = [m for part in self._parts for m in part.tolist() if along[m].max() > ROUNDING]
        # A facet that the step runs in leaves rounding only of thrusts that push along it.
        push = np.zeros_like(self._push[used])
        push[:, moved] = self._push[np.ix_(used, moved)]
        rows = self._along(level, push)
        self._measure(level, used)
        kept, most, zero = c(keep), c(keep), number(0.0, T)
        place = {m: j for j, part in enumerate(self._parts) for m in part.tolist()}
        terms = dict(zip(used, rows, strict=True))
        G = np.where(D.any(axis=1), self._G, 0.0)
        alike = _alike(used, push @ G if len(self._maps) > 1 else np.eye(len(used)))
        # With rooms to be found, backwards: GCC then spills fewer registers of a Cortex-M7 to the stack.
        for same in alike[:: -1 if self._bounds.at_call else 1]:
            (m, first), back = same[0], all(minus for minus, _ in terms[same[0][0]])
            self._arrive(place[m])
            row = [(minus != back, text) for minus, text in terms[m]]
            self.definitions.append(defined(f"a{level}_{m}", signed_sum(row, T), c))
            rooms = [self._rooms[each][:: -1 if back != (turned != first) else 1] for each, turned in same]
            ahead, astern = (self._least(list(side)) for side in zip(*rooms, strict=True))
            tiny = self._tiny.get((level, place[m]), zero)
            load = self._load(f"a{level}_{m}", ahead, astern, tiny)
            # One after the other: all at once would need more registers than a processor has.
            self.statements.append(defined(f"load{level}_{m}", f"most({load}, {most})", c))
            most = f"load{level}_{m}"
        # What is reported is rounded and what is moved is not, so that no branch is needed in between.
        self.statements.append(defined(f"part{level}", f"{kept} / {most}", c))
        rounded = f"rounded(part{level}, {c(1.0 - EDGE[T])})"
        self.definitions.append(defined(f"share{level}", rounded, c))

    def _along(self, level: int, push: FloatArray) -> list[Terms]:
        """The sums push d, out of d or of the products that d is a sum of, whichever are fewer terms."""
        c = self._c
        lines, rows, _ = product(push, f"d{level}_", c, f"pa{level}_")
        sums, rows = butterflies(rows, c, f"sa{level}_")
        used = np.flatnonzero(push.any(axis=0)).tolist()
        texts = list(dict.fromkeys(text for i in used for _, text in self._products[i]))
        if all(self._products[i] for i in used):
            spread = np.zeros((push.shape[1], len(texts)))
            for i in used:
                for minus, text in self._products[i]:
                    spread[i, texts.index(text)] = -1.0 if minus else 1.0
            more, fewer, _ = product(push @ spread, f"go{level}_", c, f"pgo{level}_")
            added, fewer = butterflies(fewer, c, f"sgo{level}_")
            if sum(map(len, fewer)) + len(added) < sum(map(len, rows)) + len(sums):
                alias = [defined(f"go{level}_{j}", text, c) for j, text in enumerate(texts)]
                self.definitions += [*alias, *more, *added]
                return fewer
        self.definitions += [*lines, *sums]
        return rows

    def _measure(self, level: int, used: list[int]) -> None:
        """Definitions of the rooms of these facets, where they are not known from the level before."""
        c, n = self._c, self._vehicle.n
        asked = [m for m in used if m not in self._rooms]
        push = self._push[asked]
        table = np.block([[push.clip(0.0), -push.clip(max=0.0)], [-push.clip(max=0.0), push.clip(0.0)]])
        widths = np.zeros(2 * n)
        for i in np.flatnonzero(push.any(axis=0)).tolist():
            low, high, f = *self._bounds.ends(i), self._f[i]
            if isinstance(f, float) and not self._bounds.at_call:
                widths[[i, n + i]] = self._vehicle.f_max[i] - f, f - self._vehicle.f_min[i]
            up, down = self._gaps.get(i, (f"{high} - {self._text(f)}", f"{self._text(f)} - {low}"))
            self.definitions += [
                defined(f"g{level}_{i}", up, c),
                defined(f"g{level}_{n + i}", down, c),
            ]
            if self._bounds.at_call:
                self._gaps[i] = (f"g{level}_{i}", f"g{level}_{n + i}")
        lines, rows, _ = product(table, f"g{level}_", c, f"pg{level}_")
        sums, rows = butterflies(rows, c, f"sg{level}_")
        self.definitions += [*lines, *sums]
        half = len(asked)
        known = [
            not self._bounds.at_call and all(isinstance(self._f[i], float) for i in np.flatnonzero(row))
            for row in push
        ]
        rooms = (table @ widths).tolist()
        for j, m in enumerate(asked):
            if known[j]:
                self._rooms[m] = (rooms[j], rooms[half + j])
                continue
            names = f"room{level}_{m}", f"back{level}_{m}"
            for name, row in zip(names, (rows[j], rows[half + j]), strict=True):
                self.definitions.append(defined(name, signed_sum(row, c.scalar), c))
                self._sums[name] = [text for _, text in row]
            self._rooms[m] = names

    def _load(self, along: str, ahead: Value, astern: Value, tiny: str) -> str:
        """What the step takes of the room that it has along a facet's normal, or along its opposite."""
        roomy = ROOMY * self._vehicle.f_scale
        if isinstance(ahead, float) and isinstance(astern, float) and min(ahead, astern) > roomy:
            if ahead == astern:
                return f"size({along} * {self._c(1.0 / ahead)})"
            return f"most({along} * {self._c(1.0 / ahead)}, -{along} * {self._c(1.0 / astern)})"
        return f"load({along}, {self._text(ahead)}, {self._text(astern)}, {tiny})"

    def _least(self, rooms: list[Value]) -> Value:
        known = [room for room in rooms if isinstance(room, float)]
        if len(known) == len(rooms):
            return min(known)
        # The least of all sums of one of these and one of those is the sum of the least.
        pairs = [tuple(self._sums.get(self._text(room), [])) for room in rooms]
        if len(pairs) > 1 and all(len(pair) == 2 for pair in pairs):
            these = sorted(_joined(pairs))
            those = sorted({text for pair in pairs for text in pair} - {*these})
            each = {frozenset((a, b)) for a in these for b in those}
            if len(these) * len(those) == len(pairs) and each == {frozenset(pair) for pair in pairs}:
                return f"{fold('least', these)} + {fold('least', those)}"
        return fold("least", [self._text(room) for room in rooms])

    def _move(self, level: int, moved: list[int]) -> None:
        """Definitions of f after a level."""
        for i in moved:
            before = f"{self._text(self._f[i])} + " if self._f[i] != 0.0 else ""
            name = f"f{level + 1}_{i}"
            self.definitions.append(defined(name, f"{before}part{level} * d{level}_{i}", self._c))
            self._f[i] = name
            if i in self._gaps:  # so that limits need not be kept, nor read again
                up, down = self._gaps[i]
                step = f"part{level} * d{level}_{i}"
                self._gaps[i] = (f"{up} - {step}", f"{down} + {step}")
        touched = np.flatnonzero(np.abs(self._push[:, moved]).sum(axis=1))
        self._rooms = {m: room for m, room in self._rooms.items() if m not in touched}

    def _end(self, structure: Structure) -> None:
        """Definitions of x, thrusts f without what they have in the null space, or for one dimension of z.

        There x is f, and z says where it would be without.
        """
        vehicle, c = self._vehicle, self._c
        rows: dict[int, Terms] = {i: [] for i in vehicle.working.tolist()}
        for b, block in enumerate(() if self.resting else structure.blocks):
            # N in unit of its first row, so that zero entries stay zero and equal sizes become one.
            N = block.N / (block.N[0] if block.N.shape[1] == 1 else np.abs(block.N).max(axis=0))
            # A full H also couples what z moves with thrusters that it doesn't.
            NtH = np.where(vehicle.readiness > 0, N.T @ vehicle.H[block.rows], 0.0)
            wide = -np.linalg.solve(NtH[:, block.rows] @ N, NtH)
            lines, inner = gathered(wide, "r", c, f"sz{b}_")
            self.definitions += lines
            z = names(f"z{b}_", N.shape[1]) if N.shape[1] > 1 else [f"z{b}"]
            self.definitions += [
                defined(name, signed_sum(row, c.scalar), c) for name, row in zip(z, inner, strict=True)
            ]
            if N.shape[1] == 1:
                continue
            lines, outer, _ = product(N, f"z{b}_", c, f"pz{b}_")
            self.definitions += lines
            for i, row in zip(block.rows.tolist(), outer, strict=True):
                rows[i] = row
        for i in vehicle.working.tolist():
            self.definitions += [
                defined(f"r{i}", self._text(self._f[i]), c),
                defined(f"x{i}", signed_sum([(False, f"r{i}"), *rows[i]], c.scalar), c),
            ]

    def _text(self, value: Value) -> str:
        return self._c(value) if isinstance(value, float) else value


def _joined(pairs: Sequence[tuple[str, ...]]) -> set[str]:
    """Those that stand with what the first pair's second stands with; the other side of a product of sets."""
    return {a for pair in pairs if pairs[0][1] in pair for a in pair} - {pairs[0][1]}


def _whole(vehicle: Vehicle, way: Way) -> BoolArray:
    """(levels, k) axes that a level moves together with all others that share their thrusters.

    These go all the way: d = G tau - f makes the same step as D (tau - T f).
    """
    if len(way.levels) == 1:
        return np.ones((1, vehicle.k), dtype=bool)
    alone = [group for group in groups(vehicle) if vehicle.rank == vehicle.k]
    return np.array(
        [
            [any(axis in group and {*group} <= {*level} for group in alone) for axis in vehicle.dof]
            for level in way.levels
        ]
    )


def _alike(used: list[int], along: FloatArray) -> list[list[tuple[int, bool]]]:
    """Facets that every step goes along alike, each with whether it does so backwards; along (M, k)."""
    groups: dict[tuple[float, ...], list[tuple[int, bool]]] = {}
    for m, row in zip(used, snapped(along) if along.size else along, strict=True):
        turned = bool(row[np.flatnonzero(row)[:1]].sum() < 0)
        groups.setdefault(tuple((-row if turned else row).tolist()), []).append((m, turned))
    return list(groups.values())


def components(linked: BoolArray) -> list[IndexArray]:
    """The rows of (M, n) in parts that share no column."""
    near = linked @ linked.T
    for _ in range(linked.shape[1].bit_length()):  # each product doubles the way that is gone
        near = near @ near
    return [np.flatnonzero(row) for row in np.unique(near, axis=0)[::-1]]


def by_level(formulation: Formulation) -> Callable[[Vehicle, CLimits, Table], list[str]]:
    """The statements of the method that answers this formulation."""
    assert formulation.way is not None
    way_of = formulation.way

    def statements(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
        way, structure = way_of(vehicle), decompose(vehicle)
        walk, later = Walk(vehicle, way, structure, bounds, c), bounds.again("e")
        read_in = [*read(vehicle, c), *bounds.definitions(), *later.definitions()]
        definitions = [*read_in, *walk.definitions]
        lines = refused(walk.sums, walk.excess, crossed(bounds, c), c)
        early: list[str] = []
        at = 0
        zero = "" if walk.resting else "z"
        ready = pieces(vehicle, structure, inf, later, c, zero)
        for end, _ in walk.ends:
            early += walk.statements[at:end]
            at = end
            for piece in [piece for piece in ready if walk.arrived(piece.rows) == end]:
                answer = ["fence();"] * bounds.at_call
                answer += [*piece.before, *piece.after, *inside(piece.thrusts, later, c)]
                written = [f"f[{i}] = y{i};" for i in piece.thrusts]
                if end == walk.ends[-1][0]:
                    lines += [*answer, *written]
                else:
                    early += answer
                    lines += written
        lines = [*early, *walk.statements[at:], *lines]
        lines += [f"f[{i}] = {number(0.0, c.scalar)};" for i in np.flatnonzero(vehicle.readiness == 0)]
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
    lines, rows, _ = product(lost / MET[c.scalar], "t", c, "pm")
    missed = [defined(f"missed{i}", signed_sum(row, c.scalar), c) for i, row in enumerate(rows)]
    squares = " + ".join(f"missed{i} * missed{i}" for i in range(len(rows)))
    return [*lines, *missed], f"{whole} && {squares} <= {one}"
