"""C99 of ``Region.nearest``: Seidel's steps on the tables of one block, written out."""

from math import isfinite
from typing import NamedTuple

from alloc.native.code import Table, dot, fold, names, number, term
from alloc.nullspace.region import Region, Slab


class Limits(NamedTuple):
    """Limits low <= offset + a'z <= high of one row a, as C expressions.

    The offset stands alone so that low and high stay constants: two differences for each row, low - offset
    and high - offset, would need twice the registers and stack.

    Attributes
    ----------
    low, high : constants, unless rows were merged into one slab
    offset : the part of the row that is known before z; empty where it is zero
    """

    low: str
    high: str
    offset: str

    @property
    def ends(self) -> tuple[str, str]:
        """The two expressions that a'z must lie between."""
        away = f" - {self.offset}" if self.offset else ""
        return f"({self.low}{away})", f"({self.high}{away})"

    def moved(self, shift: float, b: str, c: Table) -> "Limits":
        """The limits after a step that adds shift * b to a'z."""
        if not shift:
            return self
        sign, text = term(shift, b, c)
        return self._replace(offset=f"({self.offset} {'-' if sign else '+'} {text})")


def nearest(region: Region, limits: list[Limits], z: list[str], at: str, c: Table) -> list[str]:
    """Statements that set the variables ``z``; INFEASIBLE is returned unless the tolerance is infinite.

    Names of this level end in ``at``.
    """
    zero, lines = number(0.0, c.scalar), []
    refusing = isfinite(region.tolerance)
    if region.checks and refusing:
        held = [f"({limits[row].ends[0]} <= {c(region.tolerance)})" for row in region.checks]
        held += [f"({limits[row].ends[1]} >= {c(-region.tolerance)})" for row in region.checks]
        lines += _unless(" & ".join(held))
    slab_limits = []
    for i, slab in enumerate(region.slabs):
        statements, merged = _merged(slab, limits, f"{at}{i}", region.d == 1, c)
        lines += statements
        slab_limits.append(merged)
    wide = [
        f"(lo{at}{i} - hi{at}{i} <= {c(slab.slack)})"
        for i, slab in enumerate(region.slabs)
        if refusing and (len(slab.members) > 1 or region.d == 1)
    ]
    lines += _unless(" & ".join(wide)) if wide else []
    if region.d == 1:
        if region.slabs:
            base = region.slabs[0].base[0]
            lines.append(f"{z[0]} = {dot([base], [f'most(lo{at}0, least(hi{at}0, {zero}))'], c)};")
        return lines
    for i, slab in enumerate(region.slabs):
        lines += _slab(slab, slab_limits[: i + 1], z, at, c)
    return lines


def _merged(slab: Slab, limits: list[Limits], at: str, always: bool, c: Table) -> tuple[list[str], Limits]:
    """Statements, and the common limits of a slab's members; a single one keeps its own unless ``always``."""
    if len(slab.members) == 1 and not always:
        limit = limits[slab.members[0][0]]  # a single member is the slab's normal, so its scale is 1
        if not limit.offset:
            return [], limit
        return [f"const {c.scalar} u{at} = {limit.offset};"], limit._replace(offset=f"u{at}")
    lows, highs = [], []
    for row, scale in slab.members:
        low, high = limits[row].ends[:: 1 if scale > 0 else -1]
        lows.append(dot([scale], [low], c))
        highs.append(dot([scale], [high], c))
    lines = [
        f"const {c.scalar} lo{at} = {fold('most', lows)};",
        f"const {c.scalar} hi{at} = {fold('least', highs)};",
    ]
    return lines, Limits(f"lo{at}", f"hi{at}", "")


def _slab(slab: Slab, limits: list[Limits], z: list[str], at: str, c: Table) -> list[str]:
    """Statements that keep z if it lies in the last slab, else move to the violated plane and solve there."""
    *earlier, (low, high, offset) = limits
    T, zero, at = c.scalar, number(0.0, c.scalar), f"{at}{len(earlier)}"
    b, y = f"b{at}", names(f"y{at}_", len(z) - 1)
    # Before the first slab z is zero.
    sums = [text for text in (offset, dot(slab.normal, z, c) if earlier else "") if text] or [zero]
    away = f" - {offset}" if offset else ""
    inside = [f"const {T} {b} = (s{at} < {low} ? {low} : {high}){away};"]
    if earlier:
        assert slab.plane is not None
        inside.append(f"{T} {', '.join(f'{e} = {zero}' for e in y)};")
        moved = [limit.moved(shift, b, c) for limit, shift in zip(earlier, slab.shift, strict=True)]
        inside += nearest(slab.plane, moved, y, f"{at}_", c)
    for name, base, row in zip(z, slab.base, slab.along, strict=True):
        # Without earlier slabs y is zero.
        inside.append(f"{name} = {dot([base, *row], [b, *y], c) if earlier else dot([base], [b], c)};")
    return [
        f"const {T} s{at} = {' + '.join(sums)};",
        f"if (s{at} < {low} || s{at} > {high}) {{",
        *(f"    {line}" for line in inside),
        "}",
    ]


def _unless(condition: str) -> list[str]:
    return [f"if (!({condition})) {{", "    return INFEASIBLE;", "}"]
