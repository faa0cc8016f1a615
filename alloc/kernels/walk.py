"""Way towards a demand as part of a kernel: its start, and the steps along facets.

On the way only the wrench T f counts, so f may lie beyond limits: a step of the wrench is any d with T d
that step, and the margin along a facet is a sum over thrusters of what lies between f and a limit.
"""

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.kernels.entry import TAU, Place, SeenArguments, cover
from alloc.kernels.facets import alike, facet_pairs, steps_along
from alloc.kernels.margins import FacetMargins, Ways
from alloc.kernels.off import reachable
from alloc.program import Builder, Expression, Limits, Number, Scalar, most, select, size, within
from alloc.program.sums import Terms, dot, gathered, known, product, shared_sums, signed, snapped
from alloc.reach import edge
from alloc.reach.edge import INSET, start
from alloc.reach.way import Way, groups, pushes, step_maps
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import ROUNDED


def departure(builder: Builder, limits: Limits) -> list[Number]:
    """The thrusts f0 within limits (see ``alloc.reach.edge.start``)."""
    vehicle = builder.vehicle
    if limits.by_fault:
        return [builder.graph.of_each(each) for each in start(*limits.by_fault).T]
    if not limits.at_call:
        return list(np.where(vehicle.readiness > 0, start(vehicle.f_min, vehicle.f_max), 0.0))
    f: list[Number] = [0.0] * vehicle.n
    for i in vehicle.working.tolist():
        near = within(0.0, *limits.ends(i)).named(f"near{i}")
        inset = (limits.crossing(i) * INSET).named(f"in{i}")
        f[i] = (near + within(near, inset, -inset)).named(f"f{i}")
    return f


def largest(vehicle: Vehicle, f0: list[Number]) -> float:
    """Size of the largest of these thrusts, whatever the limits of a call are [N]."""
    return max(vehicle.f_scale if isinstance(f, Expression) else abs(f) for f in f0)


def remaining(builder: Builder, f0: list[Number]) -> list[Expression]:
    """tau - T f0."""
    vehicle = builder.vehicle
    fixed = vehicle.TP @ [0.0 if isinstance(f, Expression) else f for f in f0]
    of_call = [f for f in f0 if isinstance(f, Expression)]
    moving = vehicle.TP[:, [not known(f) for f in f0]]
    rows = gathered(moving, of_call, "w") if of_call else [Terms() for _ in fixed]
    found = []
    for r, (terms, constant) in enumerate(zip(rows, fixed.tolist(), strict=True)):
        left: Terms = [(False, builder.tau[r]), *((not minus, value) for minus, value in terms)]
        left += [(constant > 0, builder.graph.constant(abs(constant)))] if constant else []
        found.append(signed(left).named(f"n0_{r}"))
    return found


PARALLEL: dict[Scalar, float] = {"double": edge.PARALLEL, "float": 5e-7}
EDGE: dict[Scalar, float] = {"double": edge.EDGE, "float": 4e-6}
"""Tolerances of a step, ``alloc.reach.edge``'s in double; in float PARALLEL is some eight roundings of it. A
step that runs out of a facet by more is no longer met by thrusts within half of MET."""


class Walk:
    """The way of one kernel.

    Attributes
    ----------
    levels : how many levels there are
    start : (n,) thrusts that it begins with
    f : (n,) thrusts that make the wrench which is reached so far
    proportional : whether all shares together are a factor of the way: no step depends on those before it
    starts_at_rest : whether it begins without thrust, so that f is what G makes of the wrench
    shares : of each level so far, what is delivered
    seen : the sums of arguments that the steps hold, of all arguments in the end
    reachable : the demand without what a fault leaves unreachable
    """

    def __init__(self, builder: Builder, way: Way, G: FloatArray) -> None:
        """Prepare the way; G is (n, k), T*. Raises NotApplicable where there are too many facets."""
        vehicle = builder.vehicle
        self._draft, self._G, self._keep = builder, G, way.keep
        self.reachable = reachable(builder)
        self._facets = facet_pairs(vehicle)
        self._margins = FacetMargins(builder, self._facets)
        self._maps = step_maps(vehicle, way.levels)
        self._whole = _whole(vehicle, way)
        self._pushes = pushes(vehicle, vehicle.TP, ROUNDED)
        self.proportional = not any(
            np.abs(later @ D).max() > 0.0 for j, D in enumerate(self._maps) for later in self._maps[j + 1 :]
        )
        self._part: int | None = None
        self._entered: set[int] = set()
        self.levels, self.shares = len(self._maps), list[Expression]()
        self.seen = SeenArguments(self._cover(), builder)
        self.start = departure(builder, builder.limits)
        self.f = [*self.start]
        self.starts_at_rest = all(f == 0.0 for f in self.f)
        self._remaining = [] if self._whole[0].all() else remaining(builder, self.f)
        # With several levels f0 is multiplied by T and then by G.
        through = (np.abs(G) @ np.abs(vehicle.TP)).sum(axis=1).max() if self.levels > 1 else 1.0
        self._size = max(vehicle.f_scale, max(1.0, float(through)) * largest(vehicle, self.f))
        self._unreached = self.reachable.size(builder, G)

    def arrived(self, rows: list[int]) -> int:
        """The last level that moves one of these thrusters; the last of all where none does."""
        levels = [level for level in range(self.levels) if snapped(self._matrix(level))[rows].any()]
        return levels[-1] if levels else self.levels - 1

    def take(self, level: int) -> None:
        """Steps to the level's share, and f behind it."""
        builder = self._draft
        steps, products, tiny = self._step(level)
        self.seen.know(level, steps)
        part, ways = self._stop(level, steps, products, tiny)
        # What is reported is rounded and what is moved is not, so that no branch is needed in between.
        self.shares.append(select(part < 1.0 - EDGE[builder.scalar], part, 1.0).named(f"share{level}"))
        moves = {i: part * d for i, d in steps.items()}
        self._margins.moved(moves, part, ways)
        for i, move in moves.items():
            self.f[i] = (move if self.f[i] == 0.0 else self.f[i] + move).named(f"f{level + 1}_{i}")
        if self._remaining and level + 1 < self.levels:
            for r, wanted in self._wanted(level).items():
                if not self._whole[level, r]:
                    rest = self._remaining[r] - part * wanted
                    self._remaining[r] = rest.named(f"n{level + 1}_{r}")
        self._leave()
        if level + 1 == self.levels:
            self._enter(sorted(set(builder.vehicle.working.tolist()) - self._entered), "left")

    def _cover(self) -> list[Place]:
        """Few steps of thrusts, of any level, and entries of tau, in which every entry of tau appears."""
        found, rest = list[Place](), np.ones(self._draft.vehicle.k, dtype=bool)
        for level, D in enumerate(self._maps):
            into = self._G @ D if self.levels > 1 else self._G
            found += [at for at in cover(into * rest, level) if at[0] != TAU]
            rest &= ~snapped(into).any(axis=0)
        return [*found, *((TAU, int(j)) for j in np.flatnonzero(rest))]

    def _matrix(self, level: int) -> FloatArray:
        """(n, k) what makes the level's step of what ``_wanted`` has."""
        matrix: FloatArray = np.where(self._maps[level].any(axis=1) | self._whole[level], self._G, 0.0)
        return matrix

    def _wanted(self, level: int) -> dict[int, Expression]:
        """Target of the level's axes, or their step D n where others go along; n is tau - T f."""
        D, tau = self._maps[level], self.reachable.tau
        return {
            r: tau[r]
            if self._whole[level, r]
            else signed(dot(D[r].tolist(), self._remaining)).named(f"m{level}_{r}")
            for r in range(len(tau))
            if self._whole[level, r] or D[r].any()
        }

    def _step(self, level: int) -> tuple[dict[int, Expression], dict[int, Terms], list[Number]]:
        """Thrusts d that make the level's step, the products that each adds up, and what is rounding of it.

        Where axes go all the way G makes what they are to reach, and d is that without f; for others G makes
        the step itself. Of a d that takes f away no products are given.
        """
        vehicle = self._draft.vehicle
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
            if back and known(at) and isinstance(at, float) and at < 0.0:
                back = [(False, self._constant(-at))]
            summed[i] = [] if back else products.rows[i]
            steps[i] = signed([*rows[i], *back]).named(f"d{level}_{i}")
        return steps, summed, self._tiny(level, snapped(matrix), products.largest, away)

    def _constant(self, number: float) -> Expression:
        return self._draft.graph.constant(number)

    def _tiny(self, level: int, G: FloatArray, most_of: list[Expression], away: list[Number]) -> list[Number]:
        """Rounding of a step along facets, beside its products and the largest limit; by part."""
        found: list[Number] = [0.0] * len(self._facets.parts)
        for part in range(len(found)):
            pushing = self._facets.thrusters(part)
            sizes: list[Number] = [size(most_of[r]) for r in np.flatnonzero(G[pushing].any(axis=0)).tolist()]
            if len(sizes) == 1 and all(away[i] == 0.0 for i in pushing):
                sizes = []  # a sum of one product is never tiny beside that product
            sizes.append(self._size)
            sizes += [self._unreached] if self._unreached else []
            tiny = PARALLEL[self._draft.scalar] * most(*sizes)
            found[part] = tiny.named(f"tiny{level}_{part}") if isinstance(tiny, Expression) else tiny
        return found

    def _stop(
        self, level: int, steps: dict[int, Expression], products: dict[int, Terms], tiny: list[Number]
    ) -> tuple[Expression, Ways]:
        """Steps to the level's share, not rounded: the least that a facet's margin leaves of the step.

        Gives the share, and how far the whole step goes along the facets' normals.
        """
        builder, D, keep = self._draft, self._maps[level], self._keep[level]
        met = self._facets.met(D)
        # A facet that the step runs in leaves rounding only of thrusts that push along it.
        push = np.zeros_like(self._facets.push[met])
        push[:, list(steps)] = self._facets.push[np.ix_(met, list(steps))]
        terms = dict(zip(met, steps_along(push, steps, products, f"{level}_"), strict=True))
        self._margins.measure(level, met, self.f if builder.limits.at_call else self.start)
        load: Number = keep
        ways = Ways()
        G = np.where(D.any(axis=1), self._G, 0.0)
        together = alike(met, push @ G if self.levels > 1 else np.eye(len(met)))
        # With margins to be found, backwards: GCC then spills fewer registers of a Cortex-M7 to the stack.
        for group in together[:: -1 if builder.limits.at_call else 1]:
            m = group[0][0]
            part = self._facets.part_of(m)
            self._turn_to(part)
            # A sum that is subtracted as a whole is taken the other way round, and so are the margins.
            back = all(minus for minus, _ in terms[m])
            along = signed([(minus != back, value) for minus, value in terms[m]], builder.graph)
            pairs = [(pair, turned != back) for pair, turned in group]
            ways.append((along.named(f"a{level}_{m}"), pairs))
            found = self._margins.load(along, pairs, tiny[part])
            # One after the other: all at once would need more registers than a processor has.
            load = most(found, load).named(f"load{level}_{m}")
            builder.compute(load)
        share = keep / (load if isinstance(load, Expression) else self._constant(load))
        builder.compute(share.named(f"part{level}"))
        return share, ways

    def _turn_to(self, part: int) -> None:
        """Steps before the first facet of another part; with a fence no argument is read earlier."""
        if part == self._part:
            return
        self._leave()
        if self._part is not None and self._draft.limits.at_call:
            self._draft.fence()
        self._part = part

    def _leave(self) -> None:
        """Steps behind the facets of a part: that their thrusters' arguments are seen."""
        if self._part is not None:
            rows = self._facets.thrusters(self._part)
            self._enter([] if self._entered.issuperset(rows) else rows, f"{self._part}")

    def _enter(self, rows: list[int], name: str) -> None:
        if rows:
            self.seen.add(rows, name)
            self._entered |= set(rows)


def _whole(vehicle: Vehicle, way: Way) -> BoolArray:
    """(levels, k) axes that a level moves together with all others that share their thrusters.

    These go all the way: d = G tau - f makes the same step as D (tau - T f).
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
