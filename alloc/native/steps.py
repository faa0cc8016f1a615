"""C99 of ``Region.nearest``: Seidel's steps on the tables of one block, written out."""

from typing import NamedTuple

from alloc.native.code import Table, dot, fold, names, number, term
from alloc.nullspace.region import Region, Slab


class Limits(NamedTuple):
    """low <= offset + a'z <= high for one row a, as C expressions; an empty offset is none.

    low and high stay constants as long as they can: one offset a row is half of what two differences,
    low - offset and high - offset, would have a call keep in registers and on the stack.
    """

    low: str
    high: str
    offset: str

    @property
    def ends(self) -> tuple[str, str]:
        """What a'z must lie between."""
        away = f" - {self.offset}" if self.offset else ""
        return f"({self.low}{away})", f"({self.high}{away})"

    def moved(self, shift: float, b: str, c: Table) -> "Limits":
        """The same after a step that adds shift * b to a'z."""
        if not shift:
            return self
        sign, text = term(shift, b, c)
        return self._replace(offset=f"({self.offset} {'-' if sign else '+'} {text})")


def nearest(region: Region, limits: list[Limits], z: list[str], at: str, c: Table) -> list[str]:
    """Statements that set the variables ``z`` or return INFEASIBLE; names of this level end in ``at``."""
    zero, lines = number(0.0, c.scalar), []
    if region.checks:
        held = [f"({limits[row].ends[0]} <= {c(region.tolerance)})" for row in region.checks]
        held += [f"({limits[row].ends[1]} >= {c(-region.tolerance)})" for row in region.checks]
        lines += _unless(" & ".join(held))
    kept = []
    for i, slab in enumerate(region.slabs):
        more, limit = _together(slab, limits, f"{at}{i}", region.d == 1, c)
        lines += more
        kept.append(limit)
    wide = [
        f"(lo{at}{i} - hi{at}{i} <= {c(slab.slack)})"
        for i, slab in enumerate(region.slabs)
        if len(slab.members) > 1 or region.d == 1
    ]
    lines += _unless(" & ".join(wide)) if wide else []
    if region.d == 1:
        if region.slabs:
            base = region.slabs[0].base[0]
            lines.append(f"{z[0]} = {dot([base], [f'most(lo{at}0, least(hi{at}0, {zero}))'], c)};")
        return lines
    for i, slab in enumerate(region.slabs):
        lines += _slab(slab, kept[: i + 1], z, at, c)
    return lines


def _together(slab: Slab, limits: list[Limits], at: str, merge: bool, c: Table) -> tuple[list[str], Limits]:
    """Statements, and what a slab's members allow together; one alone keeps its own limits unless told."""
    if len(slab.members) == 1 and not merge:
        limit = limits[slab.members[0][0]]  # alone it is its own normal, so its scale is 1
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
    """Keep z if it lies in the last of the slabs; else move to the violated plane and solve there."""
    *earlier, (low, high, offset) = limits
    T, zero, at = c.scalar, number(0.0, c.scalar), f"{at}{len(earlier)}"
    b, y = f"b{at}", names(f"y{at}_", len(z) - 1)
    # With no slab before it z is still zero.
    sums = [text for text in (offset, dot(slab.normal, z, c) if earlier else "") if text] or [zero]
    away = f" - {offset}" if offset else ""
    inside = [f"const {T} {b} = (s{at} < {low} ? {low} : {high}){away};"]
    if earlier:
        assert slab.plane is not None
        inside.append(f"{T} {', '.join(f'{e} = {zero}' for e in y)};")
        moved = [limit.moved(shift, b, c) for limit, shift in zip(earlier, slab.shift, strict=True)]
        inside += nearest(slab.plane, moved, y, f"{at}_", c)
    for name, base, row in zip(z, slab.base, slab.along, strict=True):
        # Without earlier slabs the plane's own y is zero.
        inside.append(f"{name} = {dot([base, *row], [b, *y], c) if earlier else dot([base], [b], c)};")
    return [
        f"const {T} s{at} = {' + '.join(sums)};",
        f"if (s{at} < {low} || s{at} > {high}) {{",
        *(f"    {line}" for line in inside),
        "}",
    ]


def _unless(condition: str) -> list[str]:
    return [f"if (!({condition})) {{", "    return INFEASIBLE;", "}"]
