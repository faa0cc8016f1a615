"""What every kernel that knows limits begins with: T* tau, and what is refused before a thrust is written."""

from collections.abc import Sequence

import numpy as np

from alloc.allocation import FloatArray
from alloc.native.bounds import CLimits
from alloc.native.code import (
    TOLERANCE,
    Table,
    butterflies,
    defined,
    dot,
    fold,
    names,
    number,
    product,
    signed_sum,
    snapped,
)
from alloc.nullspace.structure import Structure
from alloc.vehicle import Vehicle

Excess = list[tuple[str, float]]
"""C expressions, each with what it may be at most."""


def read(vehicle: Vehicle, c: Table) -> list[str]:
    """Definitions of t, the entries of tau."""
    return [defined(f"t{j}", f"tau[{j}]", c) for j in range(vehicle.k)]


def closed_form(vehicle: Vehicle, G: FloatArray, of: str, c: Table) -> list[str]:
    """Definitions of x = G tau for each working thruster, with tau in variables that begin with ``of``."""
    lines, rows, _ = product(G, of, c)
    sums, rows = butterflies(rows, c)
    return [
        *lines,
        *sums,
        *(defined(f"x{i}", signed_sum(rows[i], c.scalar), c) for i in vehicle.working.tolist()),
    ]


class Seen:
    """What the statements so far have summed up of the arguments: no sum is finite if one of them is not.

    Attributes
    ----------
    sums : names of these sums
    crossing : names of what is at most zero only if no limits cross
    unseen : sums and entries of tau, in which every entry of tau appears, that are in no sum yet
    """

    def __init__(self, unseen: list[str], bounds: CLimits, c: Table) -> None:
        """Nothing is seen yet."""
        self.sums, self.crossing, self.unseen = list[str](), list[str](), unseen
        self._bounds, self._c = bounds, c

    def add(self, rows: list[int], name: str, of: Sequence[str] = ("x",)) -> list[str]:
        """Statements that sum up what is unseen of these thrusters, and of tau alone.

        What belongs to thruster i has one of the names in ``of`` with i behind it.
        """
        theirs = {f"{begins}{i}" for begins in of for i in rows}
        seen = [x for x in self.unseen if x in theirs or x.startswith("t")]
        self.unseen = [x for x in self.unseen if x not in seen]
        overlaps = [f"o{i}" for i in rows] if self._bounds.at_call else []
        self.sums.append(f"s{name}")
        total = " + ".join([*seen, *overlaps]) or number(0.0, self._c.scalar)
        lines = [defined(f"s{name}", total, self._c)]
        if overlaps:
            self.crossing.append(f"m{name}")
            lines.append(defined(f"m{name}", fold("most", overlaps), self._c))
        return lines


def refused(seen: Seen, excess: Excess, why: str, c: Table) -> list[str]:
    """Statements that return where an argument is not finite, limits cross, or something is exceeded.

    One comparison decides for all calls that are answered: whatever is NaN or infinite makes a sum so, its
    difference to itself NaN, and no comparison with NaN holds. ``why``, the C expression of the status, finds
    out which of the reasons it was, where that no longer costs a call that is answered.
    """
    zero = number(0.0, c.scalar)
    by_most: dict[float, list[str]] = {}
    for expression, most in excess:
        by_most.setdefault(most, []).append(expression)
    lines = [defined("sum", " + ".join([*seen.sums, *seen.unseen]), c)]
    # Whether limits cross stands outermost: a NaN beside it, of a demand that overflows, can't hide it there.
    worst, at_most = [fold("most", seen.crossing)] if seen.crossing else [], zero
    if len(by_most) == 1 and not seen.crossing:
        ((most, expressions),) = by_most.items()
        worst, at_most = [fold("most", expressions)], c(most) if most else zero
    elif by_most:
        sides = [
            fold("most", expressions) + (f" - {c(most)}" if most else "")
            for most, expressions in by_most.items()
        ]
        worst.append(fold("most", sides))
    compared = " + ".join([*([fold("most", worst)] if worst else []), "(sum - sum)"])
    return [*lines, f"if (unlikely(!({compared} <= {at_most}))) {{", f"    return {why};", "}"]


def infeasible(vehicle: Vehicle, bounds: CLimits, c: Table) -> str:
    """The status of an exact method that refuses: a sum that is not finite may have overflowed."""
    given = [("tau", 0, vehicle.k), *bounds.runs()]
    finite = " && ".join(f"finite({array}{f' + {start}' if start else ''}, {n})" for array, start, n in given)
    return f"sum - sum == {number(0.0, c.scalar)} || ({finite}) ? INFEASIBLE : NOT_FINITE"


def crossed(bounds: CLimits, c: Table) -> str:
    """The status of a method that answers every demand it can add up: INFEASIBLE where limits cross."""
    return (
        f"sum - sum == {number(0.0, c.scalar)} ? INFEASIBLE : NOT_FINITE" if bounds.at_call else "NOT_FINITE"
    )


def lost(structure: Structure, c: Table) -> tuple[list[str], Excess]:
    """Definitions, and the bound on the part of tau along directions that no thruster pushes."""
    lines: list[str] = []
    excess: Excess = []
    for i, row in enumerate(structure.unreachable):
        lines.append(defined(f"lost{i}", dot(row.tolist(), names("t", len(row)), c), c))
        excess += [(f"lost{i}", TOLERANCE[c.scalar]), (f"-lost{i}", TOLERANCE[c.scalar])]
    return lines, excess


def inside(thrusts: dict[int, str], bounds: CLimits, c: Table) -> list[str]:
    """Statements of y, the thrusts moved onto the limits that rounding or the slack took them across."""
    return [
        defined(f"y{i}", f"within({thrust}, {', '.join(bounds.ends(i))})", c) for i, thrust in thrusts.items()
    ]


def written(vehicle: Vehicle, c: Table) -> list[str]:
    """Statements that put each y into f; a thruster that is off gets zero."""
    values = [f"y{i}" if ready else number(0.0, c.scalar) for i, ready in enumerate(vehicle.readiness)]
    return [f"f[{i}] = {value};" for i, value in enumerate(values)]


def cover(vehicle: Vehicle, G: FloatArray, of: str = "x") -> list[str]:
    """Few thrusts (and entries of tau that reach none) in which every entry of tau appears."""
    used = snapped(G) != 0
    rest, chosen = np.ones(vehicle.k, dtype=bool), list[str]()
    while rest.any():
        gain = (used & rest).sum(axis=1)
        best = int(gain.argmax())
        if not gain[best]:
            return [*chosen, *(f"t{j}" for j in np.flatnonzero(rest))]
        chosen.append(f"{of}{best}")
        rest &= ~used[best]
    return chosen
