"""``Region.nearest`` for one block as a program: Seidel's steps in thrusts instead of coordinates.

A step puts a thruster at its limit. At the point of that plane nearest to the origin, each other thrust has
moved by a constant times the move of that thruster. So each step costs one product a thrust, and only
thrusts that are still needed are moved.
"""

from math import copysign, isfinite
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.kernels.entry import conjunction
from alloc.nullspace.region import Region, Slab
from alloc.program import Builder, Expression, Number, clamp, least, most
from alloc.program.graph import lifted
from alloc.program.sums import SAME, dot, signed, term
from alloc.vehicle.degeneracy import ROUNDED


class Strip(NamedTuple):
    """One row a of A, low <= start + a'z <= high, with z in coordinates of the current plane.

    Attributes
    ----------
    key : name of the current value of start + a'z
    normal : a
    start : the value at z = 0; None for zero
    low, high : limits
    """

    key: str
    normal: FloatArray
    start: Expression | None
    low: Number
    high: Number

    @property
    def ends(self) -> tuple[Number, Number]:
        """Bounds on a'z."""
        return (
            (self.low, self.high) if self.start is None else (self.low - self.start, self.high - self.start)
        )

    def value_at(self, by: float, b: Expression) -> Expression:
        """The value where a'z is ``by`` times b."""
        if not by:
            return lifted(0.0, b.graph) if self.start is None else self.start
        return signed([term(by, b)] if self.start is None else [(False, self.start), term(by, b)])


class Ratios:
    """Ratios of one block; those that differ by rounding become equal, and rounding becomes zero."""

    def __init__(self) -> None:
        """Begin with the ratio one."""
        self._known = [1.0]

    def __call__(self, value: float) -> float:
        """The value, or an earlier one that differs from it by rounding only."""
        size = abs(value)
        if size <= ROUNDED:
            return 0.0
        same = [known for known in self._known if abs(known - size) <= SAME * size]
        self._known += [] if same else [size]
        return copysign(same[0] if same else size, value)

    def ratio(self, row: Strip, held: Strip) -> float:
        """Move of a row at the nearest point per unit move of the row ``held``."""
        return self(float(row.normal @ held.normal) / float(held.normal @ held.normal))


Values = dict[str, Expression]
"""Current values by the key of a strip."""


def nearest(
    builder: Builder,
    region: Region,
    slabs: list[Strip],
    kept: list[Strip],
    values: Values,
    at: str,
    ratios: Ratios,
) -> None:
    """Set the values of ``kept`` at the region's nearest point; refuse unless the tolerance is infinite.

    ``slabs`` come from ``join_rows``; ``kept`` are the rows needed afterwards, which may be among them. Each
    value is its start so far. Names of this level end in ``at``.
    """
    if region.d > 1:
        for i, slab in enumerate(region.slabs):
            _hold_slab(builder, slab, slabs, kept, values, f"{at}{i}", ratios)
    elif slabs:
        (one,) = slabs
        w = lifted(most(one.low, least(one.high, 0.0)), builder.graph).named(f"w{at}")
        builder.compute(w)
        for row in kept:
            values[row.key] = row.value_at(ratios.ratio(row, one), w)
            builder.compute(values[row.key])


def join_rows(builder: Builder, region: Region, rows: list[Strip], values: Values, at: str) -> list[Strip]:
    """Join the region's parallel rows to slabs, and refuse limits that contradict each other.

    Joined rows, and the rows of a line, start at zero, in units of the first.
    """
    refusing = isfinite(region.tolerance)
    if region.checks and refusing:
        ends = [[lifted(end, builder.graph) for end in rows[row].ends] for row in region.checks]
        held = [low <= region.tolerance for low, _ in ends] + [high >= -region.tolerance for _, high in ends]
        builder.refuse(~conjunction(held), Status.INFEASIBLE, unlikely=False)
    slabs, not_empty = list[Strip](), list[Expression]()
    for i, slab in enumerate(region.slabs):
        (leader, _), *others = (row for alike in slab.members for row in alike.rows)
        if not others and region.d > 1:
            slabs.append(rows[leader])
            continue
        common, conditions = _common(builder, slab, rows, f"{at}{i}")
        not_empty += conditions if refusing else []
        values[common.key] = builder.graph.constant(0.0)
        slabs.append(common)
    if not_empty:
        builder.refuse(~conjunction(not_empty), Status.INFEASIBLE, unlikely=False)
    return slabs


def _common(builder: Builder, slab: Slab, rows: list[Strip], at: str) -> tuple[Strip, list[Expression]]:
    """The slab of parallel rows, and the conditions that it is not empty.

    Limits of shorter rows are moved between those of longer ones, which decide where they differ.
    """
    conditions, (lo, hi) = list[Expression](), (builder.graph.constant(0.0),) * 2
    for which, alike in enumerate(slab.members):
        lows, highs = [], []
        for row, scale in alike.rows:
            low, high = (lifted(end, builder.graph) for end in rows[row].ends[:: 1 if scale > 0 else -1])
            lows.append(signed(dot([scale], [low])))
            highs.append(signed(dot([scale], [high])))
        mark = f"{at}_{which}" if which else at
        lower, upper = most(*lows), least(*highs)
        gaps = []
        if which:
            builder.compute(lower.named(f"l{mark}"), upper.named(f"h{mark}"))
            gaps = [lower - hi, lo - upper]
            lower, upper = clamp(lower, lo, hi), clamp(upper, lo, hi)
        lo, hi = lower.named(f"lo{mark}"), upper.named(f"hi{mark}")
        builder.compute(lo, hi)
        conditions += [gap <= alike.slack for gap in (*gaps, lo - hi) if isfinite(alike.slack)]
    leader, _ = slab.members[0].rows[0]
    return Strip(f"v{at}", rows[leader].normal, None, lo, hi), conditions


def _hold_slab(
    builder: Builder,
    slab: Slab,
    slabs: list[Strip],
    kept: list[Strip],
    values: Values,
    at: str,
    ratios: Ratios,
) -> None:
    """Put a slab at the limit that is exceeded, and solve the earlier slabs there; else do nothing."""
    assert slab.plane is not None
    i = len(slab.shift)
    row, earlier, later = slabs[i], slabs[:i], slabs[i + 1 :]
    keys = {each.key for each in later}
    asked = later + [each for each in kept if each.key not in keys]
    bound = clamp(values[row.key], row.low, row.high).named(f"e{at}")
    builder.compute(bound)
    inner = dict(values)
    with builder.where(bound.differs(values[row.key])) as merged:
        b = bound if row.start is None else (bound - row.start).named(f"b{at}")
        builder.compute(b)
        moved: dict[str, Strip] = {}
        for each in (*earlier, *(each for each in asked if each.key != row.key)):
            if each.key in moved:
                continue
            inner[each.key] = value = each.value_at(ratios.ratio(each, row), b)
            moved[each.key] = each
            if slab.plane.slabs:
                value = value.named(f"u{at}_{len(moved) - 1}")
                along = np.asarray(slab.along).T @ each.normal
                moved[each.key] = each._replace(start=value, normal=along)
            builder.compute(value)
        inner[row.key] = bound
        below = join_rows(builder, slab.plane, [moved[each.key] for each in earlier], inner, f"{at}_")
        asked_below = [moved[each.key] for each in asked if each.key != row.key]
        nearest(builder, slab.plane, below, asked_below, inner, f"{at}_", ratios)
        for key in dict.fromkeys(each.key for each in asked):
            if inner[key] != values[key]:
                values[key] = merged(inner[key], values[key]).named(key)
