"""First steps of every kernel with limits: T* tau, and refusals before a thrust is written."""

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import add

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.kernels.tolerance import MOVED_ERROR
from alloc.nullspace.structure import Structure
from alloc.program import Builder, Expression, Limits, Number, clamp, most
from alloc.program.sums import dot, product, shared_sums, signed, snapped

NOT_FINITE = -2
"""Return value for an argument that is NaN or infinite."""
Excess = list[tuple[Expression, float]]
"""Values, each with its upper bound."""
Place = tuple[int, int]
"""Place of a value: (level, i) is the step of thruster i in a level, (TAU, j) is tau[j]."""
TAU = -1


def closed_form(builder: Builder, G: FloatArray) -> dict[int, Expression]:
    """x = G tau of each working thruster."""
    _, rows = shared_sums(product(G, builder.tau).rows)
    return {i: signed(rows[i], builder.graph).named(f"x{i}") for i in builder.vehicle.working.tolist()}


def refine(builder: Builder, G: FloatArray, x: dict[int, Expression]) -> dict[int, Expression]:
    """One step of iterative refinement: x + G (tau - T x)."""
    T, graph = builder.vehicle.TP[:, list(x)], builder.graph
    made = shared_sums(product(T, list(x.values()), "m").rows, "ms")[1]
    rest = [
        signed([(False, tau), *((not minus, value) for minus, value in terms)]).named(f"rest{r}")
        for r, (tau, terms) in enumerate(zip(builder.tau, made, strict=True))
    ]
    rows = shared_sums(product(G, rest, "r").rows, "rs")[1]
    return {i: (value + signed(rows[i], graph)).named(f"xr{i}") for i, value in x.items()}


class SeenArguments:
    """Sums of the arguments read so far; not finite if one argument is not.

    Attributes
    ----------
    sums : the sums
    crossing : values that are all at most zero unless f_min exceeds f_max somewhere
    """

    def __init__(self, unseen: list[Place], builder: Builder) -> None:
        """Begin with places ``unseen`` that together depend on every entry of tau."""
        self.sums, self.crossing = list[Expression](), list[Expression]()
        self._unseen, self._builder = unseen, builder
        self._known = {(TAU, j): value for j, value in enumerate(builder.tau)}

    def know(self, level: int, values: dict[int, Expression]) -> None:
        """Record a level's step of each thruster."""
        self._known |= {(level, i): value for i, value in values.items()}

    def add(self, rows: Sequence[int], name: str) -> None:
        """Sum the unseen places of these thrusters and of tau."""
        builder = self._builder
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
        """The sum of all arguments."""
        return reduce(add, [*self.sums, *(self._known[at] for at in self._unseen)]).named("sum")


def refuse(builder: Builder, seen: SeenArguments, excess: Excess, *, exact: bool) -> None:
    """Return where an argument is not finite, limits cross, or something is exceeded.

    One comparison decides for all calls that are answered: a NaN or an infinity makes the sum not finite, the
    sum less itself NaN, and the comparison false. The reason is computed on the failure path only. An
    ``exact`` method tells a sum that overflowed from an argument that is not finite; others answer every
    demand whose sum is finite, and refuse limits that cross.
    """
    limits, total = builder.limits, seen.all()
    builder.compute(total)
    by_most: dict[float, list[Expression]] = {}
    for value, bound in excess:
        by_most.setdefault(bound, []).append(value)
    # Crossing limits come last: a NaN of an overflow beside them would hide them.
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
        builder.refuse(refused, NOT_FINITE, (summed | conjunction(finite), Status.INFEASIBLE))
    else:
        cases = [(summed, int(Status.INFEASIBLE))] if limits.at_call else []
        builder.refuse(refused, NOT_FINITE, *cases)


def conjunction(conditions: Iterable[Expression]) -> Expression:
    """The condition that all of these hold."""
    return reduce(lambda a, b: a & b, conditions)


def lost_parts(builder: Builder, structure: Structure) -> Excess:
    """Bounds on the parts of tau along directions that no thruster pushes."""
    excess: Excess = []
    for i, row in enumerate(structure.unreachable):
        part = signed(dot(row.tolist(), builder.tau), builder.graph).named(f"lost{i}")
        excess += [(part, MOVED_ERROR[builder.scalar]), (-part, MOVED_ERROR[builder.scalar])]
    return excess


def clamp_thrusts(builder: Builder, thrusts: dict[int, Expression], limits: Limits) -> dict[int, Expression]:
    """Move thrusts that rounding or the slack took across a limit back onto it."""
    moved = {i: clamp(thrust, *limits.ends(i)).named(f"y{i}") for i, thrust in thrusts.items()}
    builder.compute(*moved.values())
    return moved


def all_thrusters(builder: Builder, thrusts: dict[int, Expression]) -> list[Number]:
    """The thrust of each thruster; a failed one gets zero."""
    ready = builder.vehicle.readiness.tolist()
    return [thrusts[i] if each else 0.0 for i, each in enumerate(ready)]


def cover_arguments(G: FloatArray, level: int = 0) -> list[Place]:
    """A small set of thrusts G tau, and of entries of tau, that depends on every entry of tau."""
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
