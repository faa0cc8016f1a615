"""Entry of every kernel that knows limits: T* tau, and refusals before a thrust is written."""

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import add

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.kernels.tolerance import HELD
from alloc.nullspace.structure import Structure
from alloc.program import Builder, Expression, Limits, Number, most, within
from alloc.program.sums import dot, product, shared_sums, signed, snapped

NOT_FINITE = -2
"""Returned where an argument is NaN or infinite."""
Excess = list[tuple[Expression, float]]
"""Values, each with what it may be at most."""
Place = tuple[int, int]
"""A value that depends on tau: (level, i), the step of thruster i that a level takes, or (TAU, j), tau[j]."""
TAU = -1


def closed_form(builder: Builder, G: FloatArray) -> dict[int, Expression]:
    """x = G tau of each working thruster."""
    _, rows = shared_sums(product(G, builder.tau).rows)
    return {i: signed(rows[i], builder.graph).named(f"x{i}") for i in builder.vehicle.working.tolist()}


def refined(builder: Builder, G: FloatArray, x: dict[int, Expression]) -> dict[int, Expression]:
    """x with what rounding of G takes of tau given back: x + G (tau - T x)."""
    T, graph = builder.vehicle.TP[:, list(x)], builder.graph
    made = shared_sums(product(T, list(x.values()), "m").rows, "ms")[1]
    rest = [
        signed([(False, tau), *((not minus, value) for minus, value in terms)]).named(f"rest{r}")
        for r, (tau, terms) in enumerate(zip(builder.tau, made, strict=True))
    ]
    rows = shared_sums(product(G, rest, "r").rows, "rs")[1]
    return {i: (value + signed(rows[i], graph)).named(f"xr{i}") for i, value in x.items()}


class SeenArguments:
    """Sum of the arguments that the steps so far have read: not finite if one of them is not.

    Attributes
    ----------
    sums : these sums
    crossing : what is at most zero only if no limits cross
    """

    def __init__(self, unseen: list[Place], builder: Builder) -> None:
        """Nothing is seen yet of ``unseen``, in which every entry of tau appears."""
        self.sums, self.crossing = list[Expression](), list[Expression]()
        self._unseen, self._draft = unseen, builder
        self._known = {(TAU, j): value for j, value in enumerate(builder.tau)}

    def know(self, level: int, values: dict[int, Expression]) -> None:
        """Record each thruster's step of a level."""
        self._known |= {(level, i): value for i, value in values.items()}

    def add(self, rows: Sequence[int], name: str) -> None:
        """Steps that sum up what is unseen of these thrusters, and of tau alone."""
        builder = self._draft
        seen = [at for at in self._unseen if at in self._known and (at[0] == TAU or at[1] in rows)]
        self._unseen = [at for at in self._unseen if at not in seen]
        overlaps = [builder.limits.crossing(i) for i in rows] if builder.limits.at_call else []
        terms = [*(self._known[at] for at in seen), *overlaps]
        if terms:
            self.sums.append(reduce(add, terms).named(f"s{name}"))
            builder.compute(self.sums[-1])
        if overlaps:
            self.crossing.append(most(*overlaps).named(f"m{name}"))
            builder.compute(self.crossing[-1])

    def all(self) -> Expression:
        """The sum of everything."""
        return reduce(add, [*self.sums, *(self._known[at] for at in self._unseen)]).named("sum")


def refuse(builder: Builder, seen: SeenArguments, excess: Excess, *, exact: bool) -> None:
    """Return where an argument is not finite, limits cross, or something is exceeded.

    One comparison decides for all calls that are answered: whatever is NaN or infinite makes a sum so, its
    difference to itself NaN, and no comparison with NaN holds. The reason is computed on the failure path
    only: of an ``exact`` method a sum that is not finite may have overflowed; others answer every demand that
    they can add up, and refuse limits that cross.
    """
    limits, total = builder.limits, seen.all()
    builder.compute(total)
    by_most: dict[float, list[Expression]] = {}
    for value, bound in excess:
        by_most.setdefault(bound, []).append(value)
    # Whether limits cross stands outermost: a NaN beside it, of a demand that overflows, can't hide it there.
    worst: list[Expression] = [most(*seen.crossing)] if seen.crossing else []
    at_most = 0.0
    if len(by_most) == 1 and not seen.crossing:
        ((at_most, values),) = by_most.items()
        worst = [most(*values)]
    elif by_most:
        sides = [most(*values) - bound if bound else most(*values) for bound, values in by_most.items()]
        worst.append(most(*sides))
    nothing = (total - total).named("nan_or_zero")
    refused = ~((most(*worst) + nothing if worst else nothing) <= at_most)
    summed = nothing.equals(0.0)
    if exact:
        finite = [builder.graph.value("finite", "tau", 0, builder.vehicle.k), *limits.finite()]
        builder.refuse(refused, NOT_FINITE, (summed | all_of(finite), Status.INFEASIBLE))
    else:
        cases = [(summed, int(Status.INFEASIBLE))] if limits.at_call else []
        builder.refuse(refused, NOT_FINITE, *cases)


def all_of(conditions: Iterable[Expression]) -> Expression:
    """The condition that all of these hold."""
    return reduce(lambda a, b: a & b, conditions)


def lost(builder: Builder, structure: Structure) -> Excess:
    """The bound on the part of tau along directions that no thruster pushes."""
    excess: Excess = []
    for i, row in enumerate(structure.unreachable):
        part = signed(dot(row.tolist(), builder.tau), builder.graph).named(f"lost{i}")
        excess += [(part, HELD[builder.scalar]), (-part, HELD[builder.scalar])]
    return excess


def inside(builder: Builder, thrusts: dict[int, Expression], limits: Limits) -> dict[int, Expression]:
    """Steps to y, the thrusts moved onto the limits that rounding or the slack took them across."""
    moved = {i: within(thrust, *limits.ends(i)).named(f"y{i}") for i, thrust in thrusts.items()}
    builder.compute(*moved.values())
    return moved


def all_thrusters(builder: Builder, thrusts: dict[int, Expression]) -> list[Number]:
    """The thrust of each thruster; one that is off gets zero."""
    ready = builder.vehicle.readiness.tolist()
    return [thrusts[i] if each else 0.0 for i, each in enumerate(ready)]


def cover(G: FloatArray, level: int = 0) -> list[Place]:
    """Few thrusts G tau (and entries of tau that reach none) in which every entry of tau appears."""
    used = snapped(G) != 0
    rest, chosen = np.ones(G.shape[1], dtype=bool), list[Place]()
    while rest.any():
        gain = (used & rest).sum(axis=1)
        best = int(gain.argmax())
        if not gain[best]:
            return [*chosen, *((TAU, int(j)) for j in np.flatnonzero(rest))]
        chosen.append((level, best))
        rest &= ~used[best]
    return chosen
