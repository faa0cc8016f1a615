"""C99 of ``Region.nearest``: Seidel's steps on the tables of one block, written out."""

from alloc.native.code import Table, dot, fold, names, number, term
from alloc.nullspace.region import Region, Slab


def nearest(region: Region, lower: list[str], upper: list[str], z: list[str], at: str, c: Table) -> list[str]:
    """Statements that set the variables ``z`` or return INFEASIBLE; names of this level end in ``at``."""
    T, zero, lines = c.scalar, number(0.0, c.scalar), []
    if region.checks:
        held = [f"({lower[row]} <= {c(region.tolerance)})" for row in region.checks]
        held += [f"({upper[row]} >= {c(-region.tolerance)})" for row in region.checks]
        lines += _unless(" & ".join(held))
    for i, slab in enumerate(region.slabs):
        lows, highs = [], []
        for row, scale in slab.members:
            ends = (lower[row], upper[row]) if scale > 0 else (upper[row], lower[row])
            lows.append(dot([scale], [ends[0]], c))
            highs.append(dot([scale], [ends[1]], c))
        lines.append(f"const {T} lo{at}{i} = {fold('most', lows)};")
        lines.append(f"const {T} hi{at}{i} = {fold('least', highs)};")
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
        lines += _slab(slab, i, z, at, c)
    return lines


def _slab(slab: Slab, i: int, z: list[str], at: str, c: Table) -> list[str]:
    """Keep z if it lies in slab i; else move to the violated plane and solve there."""
    T, zero, lo, hi = c.scalar, number(0.0, c.scalar), f"lo{at}{i}", f"hi{at}{i}"
    s = dot(slab.normal, z, c) if i else zero
    b, y = f"b{at}{i}", names(f"y{at}{i}_", len(z) - 1)
    inside = [f"const {T} {b} = s{at}{i} < {lo} ? {lo} : {hi};"]
    if i:
        assert slab.plane is not None
        inside.append(f"{T} {', '.join(f'{e} = {zero}' for e in y)};")
        lower = [_less(f"lo{at}{j}", shift, b, c) for j, shift in enumerate(slab.shift)]
        upper = [_less(f"hi{at}{j}", shift, b, c) for j, shift in enumerate(slab.shift)]
        inside += nearest(slab.plane, lower, upper, y, f"{at}{i}_", c)
    for name, base, row in zip(z, slab.base, slab.along, strict=True):
        # Without earlier slabs the plane's own y is zero.
        inside.append(f"{name} = {dot([base, *row], [b, *y], c) if i else dot([base], [b], c)};")
    return [
        f"const {T} s{at}{i} = {s};",
        f"if (s{at}{i} < {lo} || s{at}{i} > {hi}) {{",
        *(f"    {line}" for line in inside),
        "}",
    ]


def _less(name: str, shift: float, b: str, c: Table) -> str:
    sign, text = term(-shift, b, c)
    return f"({name} {'-' if sign else '+'} {text})" if shift else name


def _unless(condition: str) -> list[str]:
    return [f"if (!({condition})) {{", "    return INFEASIBLE;", "}"]
