"""C99 of ``Region.nearest`` for one block, written out in thrusts: Seidel's steps without coordinates.

A step holds a thruster at its limit. Of all points on that plane the nearest to the origin is where each
other thrust has moved by a constant times what the held one did, so a thrust takes one product a held
thruster, and only the thrusts that are still asked for are moved.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.native.code import Table, defined, dot, fold, number, term
from alloc.nullspace.region import Region, Slab


class Strip(NamedTuple):
    """One row a of A, low <= start + a'z <= high, with z in coordinates of the plane that steps are on.

    Attributes
    ----------
    name : C variable of start + a'z, which steps assign
    normal : a
    start : C expression of the value where z is zero; empty where that is zero
    low, high : C expressions of its limits
    """

    name: str
    normal: FloatArray
    start: str
    low: str
    high: str

    @property
    def ends(self) -> tuple[str, str]:
        """The two expressions that a'z must lie between."""
        away = f" - {self.start}" if self.start else ""
        return f"({self.low}{away})", f"({self.high}{away})"

    def moved(self, by: float, b: str, c: Table) -> str:
        """The expression of the value where a'z is ``by`` times b."""
        return _plus(self.start, by, b, c)


def nearest(region: Region, slabs: list[Strip], kept: list[Strip], at: str, c: Table) -> list[str]:
    """Statements that set the variables of ``kept``; INFEASIBLE is returned unless the tolerance is infinite.

    ``slabs`` are the region's as ``joined`` gives them, ``kept`` is what is asked for afterwards; a row may
    be in both. The variable of each holds its start already. Names of this level end in ``at``.
    """
    lines = list[str]()
    if region.d > 1:
        for i, slab in enumerate(region.slabs):
            lines += _held(slab, slabs, kept, f"{at}{i}", c)
    elif slabs:
        (one,) = slabs
        w = f"w{at}"
        lines.append(defined(w, f"most({one.low}, least({one.high}, {number(0.0, c.scalar)}))", c))
        lines += [f"{row.name} = {row.moved(_ratio(row, one, c), w, c)};" for row in kept]
    return lines


def joined(region: Region, rows: list[Strip], at: str, c: Table) -> tuple[list[str], list[Strip]]:
    """Statements, and the region's slabs out of its rows; what can't be met is refused.

    Parallel rows, and the rows of a line, start at zero, in unit of the first of them.
    """
    refusing, lines = isfinite(region.tolerance), list[str]()
    if region.checks and refusing:
        held = [f"({rows[row].ends[0]} <= {c(region.tolerance)})" for row in region.checks]
        held += [f"({rows[row].ends[1]} >= {c(-region.tolerance)})" for row in region.checks]
        lines += _unless(" & ".join(held))
    slabs, wide = [], list[str]()
    for i, slab in enumerate(region.slabs):
        (leader, _), *others = (row for alike in slab.members for row in alike.rows)
        if not others and region.d > 1:
            slabs.append(rows[leader])
            continue
        statements, common, apart = _common(slab, rows, f"{at}{i}", c)
        wide += apart if refusing else []
        lines += [*statements, *[f"{c.scalar} {common.name} = {number(0.0, c.scalar)};"] * (region.d > 1)]
        slabs.append(common)
    return lines + (_unless(" & ".join(wide)) if wide else []), slabs


def _common(slab: Slab, rows: list[Strip], at: str, c: Table) -> tuple[list[str], Strip, list[str]]:
    """Statements of a slab's limits out of its rows', the slab, and conditions that leave room between them.

    Limits of shorter rows are moved between those of longer ones, which so have the last word.
    """
    lines, apart = list[str](), list[str]()
    lo, hi = "", ""
    for which, alike in enumerate(slab.members):
        lows, highs = [], []
        for row, scale in alike.rows:
            low, high = rows[row].ends[:: 1 if scale > 0 else -1]
            lows.append(dot([scale], [low], c))
            highs.append(dot([scale], [high], c))
        least, most = fold("most", lows), fold("least", highs)
        mark = f"{at}_{which}" if which else at
        if which:
            lines += [defined(f"l{mark}", least, c), defined(f"h{mark}", most, c)]
            gaps = [f"l{mark} - {hi}", f"{lo} - h{mark}"]
            apart += [f"({gap} <= {c(alike.slack)})" for gap in gaps if isfinite(alike.slack)]
            least, most = f"within(l{mark}, {lo}, {hi})", f"within(h{mark}, {lo}, {hi})"
        lines += [defined(f"lo{mark}", least, c), defined(f"hi{mark}", most, c)]
        lo, hi = f"lo{mark}", f"hi{mark}"
        apart += [f"({lo} - {hi} <= {c(alike.slack)})"] if isfinite(alike.slack) else []
    leader, _ = slab.members[0].rows[0]
    return lines, Strip(f"v{at}", rows[leader].normal, "", lo, hi), apart


def _held(slab: Slab, slabs: list[Strip], kept: list[Strip], at: str, c: Table) -> list[str]:
    """Statements that, where the slab is left, hold it at that limit and solve the earlier ones there."""
    assert slab.plane is not None
    i = len(slab.shift)
    row, earlier, later = slabs[i], slabs[:i], slabs[i + 1 :]
    names = {each.name for each in later}
    asked = later + [each for each in kept if each.name not in names]
    bound, b = f"e{at}", f"b{at}" if row.start else f"e{at}"
    inside = []
    if row.start:
        inside.append(defined(b, f"{bound} - {row.start}", c))
    moved: dict[str, Strip] = {}
    for each in (*earlier, *(each for each in asked if each.name != row.name)):
        if each.name in moved:
            continue
        value = each.moved(_ratio(each, row, c), b, c)
        start = f"u{at}_{len(moved)}"
        along = np.asarray(slab.along).T @ each.normal
        if slab.plane.slabs:
            inside.append(defined(start, value, c))
            moved[each.name] = each._replace(start=start, normal=along)
            if slab.plane.d > 1 or each.name not in {one.name for one in earlier}:
                inside.append(f"{each.name} = {start};")
        else:
            moved[each.name] = each
            inside.append(f"{each.name} = {value};")
    if any(each.name == row.name for each in asked):
        inside.append(f"{row.name} = {bound};")
    statements, below = joined(slab.plane, [moved[each.name] for each in earlier], f"{at}_", c)
    asked_below = [moved[each.name] for each in asked if each.name != row.name]
    inside += statements + nearest(slab.plane, below, asked_below, f"{at}_", c)
    return [
        defined(bound, f"within({row.name}, {row.low}, {row.high})", c),
        f"if ({bound} != {row.name}) {{",
        *(f"    {line}" for line in inside),
        "}",
    ]


def _ratio(row: Strip, held: Strip, c: Table) -> float:
    """By how much a row's value moves to the nearest point where that of ``held`` moved by one."""
    return c.ratio(float(row.normal @ held.normal) / float(held.normal @ held.normal))


def _plus(start: str, by: float, b: str, c: Table) -> str:
    if not by:
        return start or number(0.0, c.scalar)
    sign, text = term(by, b, c)
    return f"{start} {'-' if sign else '+'} {text}" if start else f"{'-' * sign}{text}"


def _unless(condition: str) -> list[str]:
    return [f"if (!({condition})) {{", "    return INFEASIBLE;", "}"]
