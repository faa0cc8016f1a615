"""C of the way towards a demand, level by level: what ``alloc.reach.way`` takes out of tables, written out.

On the way only the wrench T f counts, so f may lie beyond limits: a step of the wrench is any d with T d
that step, and the room along a facet is a sum over thrusters of what lies between f and a limit.
"""

from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.native.bounds import CLimits
from alloc.native.code import (
    Scalar,
    Table,
    Terms,
    Value,
    butterflies,
    defined,
    expression,
    fold,
    number,
    product,
    signed_sum,
    snapped,
    term,
)
from alloc.native.departure import departure, largest, missing
from alloc.native.entry import Seen, cover
from alloc.native.facets import alike, facets, steps_along
from alloc.native.rooms import Rooms
from alloc.reach import edge
from alloc.reach.levels import groups, step_maps
from alloc.reach.way import Way
from alloc.vehicle import Vehicle

PARALLEL: dict[Scalar, float] = {"double": edge.PARALLEL, "float": 2e-6}
EDGE: dict[Scalar, float] = {"double": edge.EDGE, "float": 4e-6}
"""What ``alloc.reach.edge`` has for double, and what rounding makes of it in float."""


class Step(NamedTuple):
    """The C of one level's step, d.

    Attributes
    ----------
    moved : thrusters that it moves
    products : of each thruster those that d adds up; none where it also takes f away
    tiny : of each part of the facets, what is rounding of the step along one of them
    """

    moved: list[int]
    products: list[Terms]
    tiny: list[str]


class Walk:
    """The C of one way.

    Attributes
    ----------
    definitions : of all that statements may need
    statements : of each level, those that find out its share
    moved : the thrusters that each level moves
    starts_at_rest : whether it begins without thrust, so that f is what G makes of the wrench
    f : thrusts that make the wrench which is reached; zero where a thruster is off
    seen : the sums of arguments that the statements hold, of all arguments in the end
    """

    def __init__(self, vehicle: Vehicle, way: Way, G: FloatArray, bounds: CLimits, c: Table) -> None:
        """Write the way; G is (n, k), T*. Raises NotApplicable where there are too many facets to do so."""
        self._vehicle, self._bounds, self._c, self._G = vehicle, bounds, c, G
        self._facets = facets(vehicle)
        self._rooms = Rooms(vehicle, self._facets, bounds, c)
        self._maps = step_maps(vehicle, way.levels)
        self._whole = _whole(vehicle, way)
        self._part: int | None = None
        self._entered: set[int] = set()
        self.seen = Seen(self._cover(), bounds, c)
        self.definitions, self.f = departure(vehicle, bounds, c)
        self.statements: list[list[str]] = []
        self.moved: list[list[int]] = []
        self.starts_at_rest = all(f == 0.0 for f in self.f)
        # Several levels take f0 through T and then G.
        through = (np.abs(G) @ np.abs(vehicle.TP)).sum(axis=1).max() if len(self._maps) > 1 else 1.0
        self._size = max(1.0, float(through)) * largest(vehicle, self.f)
        for level, keep in enumerate(way.keep):
            self.statements.append([])
            step = self._step(level)
            self.moved.append(step.moved)
            self._stop(level, keep, step)
            self._move(level)
            self._leave()
        self._enter(sorted(set(vehicle.working.tolist()) - self._entered), "left")

    def arrived(self, rows: list[int]) -> int:
        """The last level that moves one of these thrusters; the last of all where none does."""
        levels = [level for level, moved in enumerate(self.moved) if not {*rows}.isdisjoint(moved)]
        return levels[-1] if levels else len(self.moved) - 1

    def _cover(self) -> list[str]:
        """Few steps of thrusts, of any level, and entries of tau, in which every entry of tau appears."""
        found, rest = list[str](), np.ones(self._vehicle.k, dtype=bool)
        for level, D in enumerate(self._maps):
            into = self._G @ D if len(self._maps) > 1 else self._G
            found += [x for x in cover(self._vehicle, into * rest, f"d{level}_") if x.startswith("d")]
            rest &= ~snapped(into).any(axis=0)
        return [*found, *(f"t{j}" for j in np.flatnonzero(rest))]

    def _step(self, level: int) -> Step:
        """Definitions of d, thrusts that make the level's step.

        Where axes go all the way G makes what they are to reach, and d is that without f; for others G makes
        the step itself.
        """
        c, T, vehicle = self._c, self._c.scalar, self._vehicle
        whole = self._whole[level]
        taken: list[Value] = [0.0] * vehicle.n
        for i in np.flatnonzero(vehicle.TP[whole].any(axis=0)).tolist():
            taken[i] = self.f[i]
        self._wanted(level)
        matrix = np.where(self._maps[level].any(axis=1) | whole, self._G, 0.0)
        lines, products, most = product(matrix, f"m{level}_", c, f"pd{level}_")
        sums, rows = butterflies(products, c, f"sd{level}_")
        self.definitions += [*lines, *sums]
        moved = [i for i in vehicle.working.tolist() if rows[i]]
        tiny = self._tiny(level, snapped(matrix), most, taken)
        for i in moved:
            away: Terms = [(True, expression(taken[i], c))] if taken[i] != 0.0 else []
            products[i] = [] if away else products[i]
            self.definitions.append(defined(f"d{level}_{i}", signed_sum([*rows[i], *away], T), c))
        return Step(moved, products, tiny)

    def _wanted(self, level: int) -> None:
        """Definitions of m, what the level's axes are to reach, or their step D n where others go along.

        n is what is missing of tau, tau - T f.
        """
        c, D, whole = self._c, self._maps[level], self._whole[level]
        self.definitions += [defined(f"m{level}_{r}", f"t{r}", c) for r in np.flatnonzero(whole)]
        if not level and not whole.all():
            self.definitions += missing(self._vehicle, self.f, c)
        for r in np.flatnonzero(~whole):
            terms = [term(float(D[r, j]), f"n{level}_{j}", c) for j in np.flatnonzero(D[r])]
            self.definitions.append(defined(f"m{level}_{r}", signed_sum(terms, c.scalar), c))
            if level + 1 < len(self._maps):
                rest = f"n{level}_{r}" + (f" - part{level} * m{level}_{r}" if terms else "")
                self.definitions.append(defined(f"n{level + 1}_{r}", rest, c))

    def _tiny(self, level: int, G: FloatArray, most: list[str], taken: list[Value]) -> list[str]:
        """Definitions of what is rounding of a step along facets, a share of its products; by part."""
        c = self._c
        found = [number(0.0, c.scalar)] * len(self._facets.parts)
        for part in range(len(found)):
            pushing = self._facets.thrusters(part)
            sizes = [f"size({most[r]})" for r in np.flatnonzero(G[pushing].any(axis=0))]
            if len(sizes) == 1 and all(taken[i] == 0.0 for i in pushing):
                sizes = []  # what goes along one product alone is never tiny beside it
            sizes += [c(self._size)] if self._size else []
            if sizes:
                found[part] = f"tiny{level}_{part}"
                share = f"{c(PARALLEL[c.scalar])} * {fold('most', sizes)}"
                self.definitions.append(defined(found[part], share, c))
        return found

    def _stop(self, level: int, keep: float, step: Step) -> None:
        """Statements of the level's share: the least that a facet's room leaves of the step."""
        c, D = self._c, self._maps[level]
        met = self._facets.met(D)
        # A facet that the step runs in leaves rounding only of thrusts that push along it.
        push = np.zeros_like(self._facets.push[met])
        push[:, step.moved] = self._facets.push[np.ix_(met, step.moved)]
        lines, rows = steps_along(push, step.products, f"{level}_", c)
        terms = dict(zip(met, rows, strict=True))
        self.definitions += [*lines, *self._rooms.measure(level, met, self.f)]
        most = c(keep)
        G = np.where(D.any(axis=1), self._G, 0.0)
        together = alike(met, push @ G if len(self._maps) > 1 else np.eye(len(met)))
        # With rooms to be found, backwards: GCC then spills fewer registers of a Cortex-M7 to the stack.
        for group in together[:: -1 if self._bounds.at_call else 1]:
            m = group[0][0]
            part = self._facets.part_of(m)
            self._turn_to(part)
            # A sum that is subtracted as a whole is taken the other way round, and so are the rooms.
            back = all(minus for minus, _ in terms[m])
            along = signed_sum([(minus != back, text) for minus, text in terms[m]], c.scalar)
            self.definitions.append(defined(f"a{level}_{m}", along, c))
            pairs = [(pair, turned != back) for pair, turned in group]
            load = self._rooms.load(f"a{level}_{m}", pairs, step.tiny[part])
            # One after the other: all at once would need more registers than a processor has.
            self.statements[-1].append(defined(f"load{level}_{m}", f"most({load}, {most})", c))
            most = f"load{level}_{m}"
        # What is reported is rounded and what is moved is not, so that no branch is needed in between.
        self.statements[-1].append(defined(f"part{level}", f"{c(keep)} / {most}", c))
        rounded = f"rounded(part{level}, {c(1.0 - EDGE[c.scalar])})"
        self.definitions.append(defined(f"share{level}", rounded, c))

    def _move(self, level: int) -> None:
        """Definitions of f after a level."""
        steps = {i: f"part{level} * d{level}_{i}" for i in self.moved[-1]}
        self._rooms.moved(steps)
        for i, step in steps.items():
            before = f"{expression(self.f[i], self._c)} + " if self.f[i] != 0.0 else ""
            self.f[i] = f"f{level + 1}_{i}"
            self.definitions.append(defined(f"f{level + 1}_{i}", f"{before}{step}", self._c))

    def _turn_to(self, part: int) -> None:
        """Statements before the first facet of another part; the fence keeps reading its arguments for then."""
        if part == self._part:
            return
        self._leave()
        if self._part is not None and self._bounds.at_call:
            self.statements[-1].append("fence();")
        self._part = part

    def _leave(self) -> None:
        """Statements behind the facets of a part: that their thrusters' arguments are seen."""
        if self._part is not None:
            rows = self._facets.thrusters(self._part)
            self._enter([] if self._entered.issuperset(rows) else rows, f"{self._part}")

    def _enter(self, rows: list[int], name: str) -> None:
        if rows:
            steps = [f"d{level}_" for level in range(len(self.moved))]
            self.statements[-1] += self.seen.add(rows, name, steps)
            self._entered |= set(rows)


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
