"""Path towards a demand as part of a kernel: its start, and its steps up to facets of the attainable set.

Only the wrench T f counts here, so f may exceed limits: any d with T d equal to a step of the wrench will
do, and the margin to a facet is a weighted sum of the distances of f to its limits.
"""

from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.kernels.entry import TAU, Place, SeenArguments, cover_arguments
from alloc.kernels.facets import facet_pairs, group_alike, steps_along
from alloc.kernels.failures import reachable
from alloc.kernels.margins import FacetMargins, Ways
from alloc.program import Builder, Expression, Limits, Number, Scalar, clamp, most, select, size
from alloc.program.sums import Terms, dot, gathered, is_constant, product, shared_sums, signed, snapped
from alloc.reach import edge
from alloc.reach.edge import INSET, start
from alloc.reach.way import Way, groups, pushes, step_maps
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import ROUNDED


def start_thrusts(builder: Builder, limits: Limits) -> list[Number]:
    """The first thrusts f0 within limits (``alloc.reach.edge.start``)."""
    vehicle = builder.vehicle
    if limits.by_fault:
        return [builder.graph.of_each(each) for each in start(*limits.by_fault).T]
    if not limits.at_call:
        return list(np.where(vehicle.readiness > 0, start(vehicle.f_min, vehicle.f_max), 0.0))
    f: list[Number] = [0.0] * vehicle.n
    for i in vehicle.working.tolist():
        near = clamp(0.0, *limits.ends(i)).named(f"near{i}")
        inset = (limits.crossing(i) * INSET).named(f"in{i}")
        f[i] = (near + clamp(near, inset, -inset)).named(f"f{i}")
    return f


def largest_thrust(vehicle: Vehicle, f0: list[Number]) -> float:
    """Bound on the largest of these thrusts for any limits of the call [N]."""
    return max(vehicle.f_scale if isinstance(f, Expression) else abs(f) for f in f0)


def remaining_demand(builder: Builder, f0: list[Number]) -> list[Expression]:
    """tau - T f0."""
    vehicle = builder.vehicle
    fixed = vehicle.TP @ [0.0 if isinstance(f, Expression) else f for f in f0]
    of_call = [f for f in f0 if isinstance(f, Expression)]
    moving = vehicle.TP[:, [not is_constant(f) for f in f0]]
    rows = gathered(moving, of_call, "w") if of_call else [Terms() for _ in fixed]
    found = []
    for r, (terms, constant) in enumerate(zip(rows, fixed.tolist(), strict=True)):
        left: Terms = [(False, builder.tau[r]), *((not minus, value) for minus, value in terms)]
        left += [(constant > 0, builder.graph.constant(abs(constant)))] if constant else []
        found.append(signed(left).named(f"n0_{r}"))
    return found


PARALLEL: dict[Scalar, float] = {"double": edge.PARALLEL, "float": 5e-7}
EDGE: dict[Scalar, float] = {"double": edge.EDGE, "float": 4e-6}
"""Tolerances of a step; in double those of ``alloc.reach.edge``, in float PARALLEL is some eight roundings. A
step that leaves a facet by more breaks half of WRENCH_ERROR."""


class _Step(NamedTuple):
    """Step of a level: thrusts [N], the products summed in each, and their rounding by part."""

    thrusts: dict[int, Expression]
    products: dict[int, Terms]
    tiny: list[Number]

    def moves(self, part: Expression) -> dict[int, Expression]:
        """A part of the step's thrusts."""
        return {i: part * d for i, d in self.thrusts.items()}


class Walk:
    """The path of one kernel.

    Attributes
    ----------
    levels : how many levels there are
    start : (n,) first thrusts [N]
    f : (n,) thrusts that make the wrench reached so far [N]
    proportional : True if no step depends on an earlier one, so scaling all shares scales the wrench
    starts_at_rest : True if the first thrusts are zero, so that f = G T f
    shares : delivered fraction of each level so far [-]
    seen : sums of the arguments read so far
    reachable : the demand without its part that a fault makes unreachable
    """

    def __init__(self, builder: Builder, way: Way, G: FloatArray) -> None:
        """Prepare the path; G (n, k) is T*. Raises NotApplicable for too many facets."""
        vehicle = builder.vehicle
        self._builder, self._G, self._keep, self._together = builder, G, way.keep, way.together
        self.reachable = reachable(builder)
        self._facets = facet_pairs(vehicle)
        self._margins = FacetMargins(builder, self._facets)
        self._maps = step_maps(vehicle, way.levels, together=way.together)
        self._whole = _whole(vehicle, way)
        self._pushes = pushes(vehicle, vehicle.TP, ROUNDED)
        self.proportional = way.together or not any(
            np.abs(later @ D).max() > 0.0 for j, D in enumerate(self._maps) for later in self._maps[j + 1 :]
        )
        self._part: int | None = None
        self._entered: set[int] = set()
        self._alone = list[tuple[_Step, Expression]]()
        self.levels, self.shares = len(self._maps), list[Expression]()
        self.seen = SeenArguments(self._cover(), builder)
        self.start = start_thrusts(builder, builder.limits)
        self.f = [*self.start]
        self.starts_at_rest = all(f == 0.0 for f in self.f)
        self._remaining = [] if self._whole[0].all() else remaining_demand(builder, self.f)
        # With several levels f0 is multiplied by T, then by G, which may enlarge it.
        through = (np.abs(G) @ np.abs(vehicle.TP)).sum(axis=1).max() if self.levels > 1 else 1.0
        self._size = max(vehicle.f_scale, max(1.0, float(through)) * largest_thrust(vehicle, self.f))
        self._unreached = self.reachable.size(builder, G)

    def arrived(self, rows: list[int]) -> int:
        """Last level that moves one of these thrusters; the last if none does, or if all start at once."""
        if self._together:
            return self.levels - 1
        levels = [level for level in range(self.levels) if snapped(self._matrix(level))[rows].any()]
        return levels[-1] if levels else self.levels - 1

    def take(self, level: int) -> None:
        """Take a level's step: its share, and f after it."""
        step = self._step(level)
        self.seen.know(level, step.thrusts)
        part, ways = self._stop(f"{level}", self._maps[level], step, self._keep[level])
        if self._together:
            self._alone.append((step, part))
            if level + 1 == self.levels:
                self._take_together()
            return
        moves = step.moves(part)
        self._share(level, part)
        self._margins.advance(moves, part, ways)
        self._move(level, moves)
        if self._remaining and level + 1 < self.levels:
            for r, wanted in self._wanted(level).items():
                if not self._whole[level, r]:
                    rest = self._remaining[r] - part * wanted
                    self._remaining[r] = rest.named(f"n{level + 1}_{r}")
        self._leave()
        if level + 1 == self.levels:
            self._enter_rest()

    def _take_together(self) -> None:
        """Take the steps of all levels, shortened by one factor until they fit."""
        thrusts = dict[int, Expression]()
        for step, part in self._alone:
            for i, d in step.moves(part).items():
                thrusts[i] = thrusts[i] + d if i in thrusts else d
        whole = _Step(
            {i: d.named(f"sum{i}") for i, d in thrusts.items()},
            {i: [] for i in thrusts},
            [most(*sizes) for sizes in zip(*(step.tiny for step, _ in self._alone), strict=True)],
        )
        factor, _ = self._stop("all", self._maps.sum(axis=0), whole, 1.0)
        for level, (_, part) in enumerate(self._alone):
            self._share(level, factor * part)
        self._move(self.levels - 1, whole.moves(factor))
        self._leave()
        self._enter_rest()

    def _share(self, level: int, part: Expression) -> None:
        """Report a level's share; it alone is rounded, so the thrusts need no branch."""
        edge_at = 1.0 - EDGE[self._builder.scalar]
        self.shares.append(select(part < edge_at, part, 1.0).named(f"share{level}"))

    def _move(self, level: int, moves: dict[int, Expression]) -> None:
        for i, move in moves.items():
            self.f[i] = (move if self.f[i] == 0.0 else self.f[i] + move).named(f"f{level + 1}_{i}")

    def _enter_rest(self) -> None:
        self._enter(sorted(set(self._builder.vehicle.working.tolist()) - self._entered), "left")

    def _cover(self) -> list[Place]:
        """A small set of places, over all levels, that depends on every entry of tau."""
        found, rest = list[Place](), np.ones(self._builder.vehicle.k, dtype=bool)
        for level, D in enumerate(self._maps):
            into = self._G @ D if self.levels > 1 else self._G
            found += [at for at in cover_arguments(into * rest, level) if at[0] != TAU]
            rest &= ~snapped(into).any(axis=0)
        return [*found, *((TAU, int(j)) for j in np.flatnonzero(rest))]

    def _matrix(self, level: int) -> FloatArray:
        """Matrix (n, k) from ``_wanted`` to the level's step of thrusts."""
        matrix: FloatArray = np.where(self._maps[level].any(axis=1) | self._whole[level], self._G, 0.0)
        return matrix

    def _wanted(self, level: int) -> dict[int, Expression]:
        """Target of each axis of the level, or its step D (tau - T f) where other axes move with it."""
        D, tau = self._maps[level], self.reachable.tau
        return {
            r: tau[r]
            if self._whole[level, r]
            else signed(dot(D[r].tolist(), self._remaining)).named(f"m{level}_{r}")
            for r in range(len(tau))
            if self._whole[level, r] or D[r].any()
        }

    def _step(self, level: int) -> _Step:
        """The level's step.

        Where axes go all the way, d = G target - f; elsewhere d = G step. A d that subtracts f has no
        products.
        """
        vehicle = self._builder.vehicle
        away: list[Number] = [0.0] * vehicle.n
        for i in np.flatnonzero(self._pushes[self._whole[level]].any(axis=0)).tolist():
            away[i] = self.f[i]
        wanted = self._wanted(level)
        matrix = self._matrix(level)[:, list(wanted)]
        products = product(matrix, list(wanted.values()), f"pd{level}_")
        rows = shared_sums(products.rows, f"sd{level}_")[1]
        steps, summed = dict[int, Expression](), dict[int, Terms]()
        for i in (i for i in vehicle.working.tolist() if rows[i]):
            at = away[i]
            back: Terms = (
                [] if at == 0.0 else [(True, at if isinstance(at, Expression) else self._constant(at))]
            )
            if back and is_constant(at) and isinstance(at, float) and at < 0.0:
                back = [(False, self._constant(-at))]
            summed[i] = [] if back else products.rows[i]
            steps[i] = signed([*rows[i], *back]).named(f"d{level}_{i}")
        return _Step(steps, summed, self._tiny(level, snapped(matrix), products.largest, away))

    def _constant(self, number: float) -> Expression:
        return self._builder.graph.constant(number)

    def _tiny(self, level: int, G: FloatArray, most_of: list[Expression], away: list[Number]) -> list[Number]:
        """Rounding of a step along facets, by part, from its products and the largest limit [N]."""
        found: list[Number] = [0.0] * len(self._facets.parts)
        for part in range(len(found)):
            pushing = self._facets.thrusters(part)
            sizes: list[Number] = [size(most_of[r]) for r in np.flatnonzero(G[pushing].any(axis=0)).tolist()]
            if len(sizes) == 1 and all(away[i] == 0.0 for i in pushing):
                sizes = []  # a sum of one product is never tiny beside that product
            sizes.append(self._size)
            sizes += [self._unreached] if self._unreached else []
            tiny = PARALLEL[self._builder.scalar] * most(*sizes)
            found[part] = tiny.named(f"tiny{level}_{part}") if isinstance(tiny, Expression) else tiny
        return found

    def _stop(self, level: str, D: FloatArray, step: _Step, keep: float) -> tuple[Expression, Ways]:
        """Share of a step that D makes, the least margin over its length along each normal; not rounded.

        Also returns the step's lengths along the normals.
        """
        builder, (steps, products, tiny) = self._builder, step
        met = self._facets.crossed_by(D)
        # A step within a facet has only rounding along its normal.
        push = np.zeros_like(self._facets.push[met])
        push[:, list(steps)] = self._facets.push[np.ix_(met, list(steps))]
        terms = dict(zip(met, steps_along(push, steps, products, f"{level}_"), strict=True))
        self._margins.measure(level, met, self.f if builder.limits.at_call else self.start)
        load: Number = keep
        ways = Ways()
        G = np.where(D.any(axis=1), self._G, 0.0)
        together = group_alike(met, push @ G if self.levels > 1 else np.eye(len(met)))
        # Backwards with limits of the call: GCC then spills fewer registers of a Cortex-M7.
        for group in together[:: -1 if builder.limits.at_call else 1]:
            m = group[0][0]
            part = self._facets.part_index(m)
            self._turn_to(part)
            # A sum whose every term is negative is computed negated, and its margins are swapped.
            back = all(minus for minus, _ in terms[m])
            along = signed([(minus != back, value) for minus, value in terms[m]], builder.graph)
            pairs = [(pair, turned != back) for pair, turned in group]
            ways.append((along.named(f"a{level}_{m}"), pairs))
            found = self._margins.load(along, pairs, tiny[part])
            # One at a time: all at once would need more registers than a processor has.
            load = most(found, load).named(f"load{level}_{m}")
            builder.compute(load)
        share = keep / (load if isinstance(load, Expression) else self._constant(load))
        builder.compute(share.named(f"part{level}"))
        return share, ways

    def _turn_to(self, part: int) -> None:
        """Begin another part of the facets; a fence keeps its arguments from being read earlier."""
        if part == self._part:
            return
        self._leave()
        if self._part is not None and self._builder.limits.at_call:
            self._builder.fence()
        self._part = part

    def _leave(self) -> None:
        """End a part of the facets: sum its thrusters' arguments."""
        if self._part is not None:
            rows = self._facets.thrusters(self._part)
            self._enter([] if self._entered.issuperset(rows) else rows, f"{self._part}")

    def _enter(self, rows: list[int], name: str) -> None:
        if rows:
            self.seen.add(rows, name)
            self._entered |= set(rows)


def _whole(vehicle: Vehicle, way: Way) -> BoolArray:
    """Axes (levels, k) that a level moves together with all axes that share their thrusters.

    For these d = G tau - f makes the same step as D (tau - T f).
    """
    if len(way.levels) == 1:
        return np.ones((1, vehicle.k), dtype=bool)
    alone = groups(vehicle, least=ROUNDED) if vehicle.rank == vehicle.k else ()
    return np.array(
        [
            [any(axis in group and {*group} <= {*level} for group in alone) for axis in vehicle.dof]
            for level in way.levels
        ]
    )
