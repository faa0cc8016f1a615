"""C99 of the exact method for one vehicle: the tables of ``alloc.nullspace`` written out as straight code."""

from alloc.errors import NotApplicable
from alloc.native.code import TOLERANCE, Table, between, dot, names, number, product, reached, signed_sum
from alloc.nullspace.region import Region, Slab, prepare
from alloc.nullspace.structure import Block, decompose
from alloc.vehicle import Vehicle

STEPS_LIMIT = 500
"""Each step is written out: more than these would fill a microcontroller's flash."""


def body(vehicle: Vehicle, c: Table) -> list[str]:
    """Statements that turn t0, t1, … into f[0], f[1], … or return INFEASIBLE with f untouched."""
    structure = decompose(vehicle)
    slack = TOLERANCE[c.scalar] * vehicle.f_scale
    lines, rows, largest = product(structure.G, "t", c)
    for i in vehicle.working.tolist():
        lines.append(f"const {c.scalar} x{i} = {signed_sum(rows[i], c.scalar)};")
    # NaN, infinity or overflow in any column makes this sum differ from itself.
    lines.append(f"const {c.scalar} sum = {' + '.join(largest)};")
    met = [f"(sum - sum == {number(0.0, c.scalar)})"]
    more, within_reach = reached(structure.unreachable, c)
    lines += more
    met += within_reach
    for i in structure.fixed.tolist():
        if vehicle.readiness[i]:
            low, high = vehicle.f_min[i] - slack, vehicle.f_max[i] + slack
            met.append(between(f"x{i}", float(low), float(high), c))
    thrusts = names("x", vehicle.n)
    solved: list[str] = []
    for index, block in enumerate(structure.blocks):
        region = prepare(block.N, slack)
        if region.worst_case_steps > STEPS_LIMIT:
            raise NotApplicable(
                f"nullspace@native: each step is written out, here {region.worst_case_steps}, "
                f"more than {STEPS_LIMIT}; use nullspace, or a qp/ method"
            )
        if region.d == 1:
            _clamp(vehicle, block, region, str(index), c, lines, met, thrusts)
        else:
            solved += _block(vehicle, block, region, str(index), c, thrusts)
    lines += [f"if (!({' & '.join(met)})) {{", "    return INFEASIBLE;", "}", *solved]
    for i in range(vehicle.n):
        low, high = c(float(vehicle.f_min[i])), c(float(vehicle.f_max[i]))
        on = vehicle.readiness[i] != 0
        lines.append(f"f[{i}] = {f'within({thrusts[i]}, {low}, {high})' if on else number(0.0, c.scalar)};")
    return [*lines, "return SOLVED;"]


def _clamp(
    vehicle: Vehicle,
    block: Block,
    region: Region,
    name: str,
    c: Table,
    lines: list[str],
    met: list[str],
    thrusts: list[str],
) -> None:
    """One dimension, no branch: the slab's lo and hi, and the point of it nearest to zero.

    Rows whose limits are alike once scaled share the subtraction: lo = limit - (least of their x).
    """
    (slab,) = region.slabs
    lows: dict[float, list[str]] = {}
    highs: dict[float, list[str]] = {}
    for row, scale in slab.members:
        i = int(block.rows[row])
        low, high = sorted((float(vehicle.f_min[i]) * scale, float(vehicle.f_max[i]) * scale))
        x = dot([scale], [f"x{i}"], c)
        lows.setdefault(low, []).append(x)
        highs.setdefault(high, []).append(x)
    lo = [f"{c(low)} - {_fold('least', xs)}" for low, xs in lows.items()]
    hi = [f"{c(high)} - {_fold('most', xs)}" for high, xs in highs.items()]
    lines += [
        f"const {c.scalar} lo{name} = {_fold('most', lo)};",
        f"const {c.scalar} hi{name} = {_fold('least', hi)};",
        f"const {c.scalar} b{name} = most(lo{name}, least(hi{name}, {number(0.0, c.scalar)}));",
    ]
    met.append(f"(lo{name} - hi{name} <= {c(slab.slack)})")
    for row, scale in slab.members:
        i = int(block.rows[row])
        thrusts[i] = signed_sum([(False, f"x{i}"), _term(1.0 / scale, f"b{name}", c)], c.scalar)


def _block(
    vehicle: Vehicle, block: Block, region: Region, name: str, c: Table, thrusts: list[str]
) -> list[str]:
    """Two dimensions and more: statements that find the block's z; its thrusts become sums with it."""
    lower = [f"({c(float(vehicle.f_min[i]))} - x{i})" for i in block.rows.tolist()]
    upper = [f"({c(float(vehicle.f_max[i]))} - x{i})" for i in block.rows.tolist()]
    z = names(f"z{name}_", region.d)
    lines = [f"{c.scalar} {', '.join(f'{e} = {number(0.0, c.scalar)}' for e in z)};"]
    lines += _nearest(region, lower, upper, z, f"{name}_", c)
    for row, i in enumerate(block.rows.tolist()):
        thrusts[i] = f"x{i} + {dot(block.N[row].tolist(), z, c)}"
    return lines


def _nearest(
    region: Region, lower: list[str], upper: list[str], z: list[str], at: str, c: Table
) -> list[str]:
    """Seidel's steps on one region, written out; they set the variables ``z``. Names carry ``at``."""
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
        lines.append(f"const {T} lo{at}{i} = {_fold('most', lows)};")
        lines.append(f"const {T} hi{at}{i} = {_fold('least', highs)};")
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
    b, y = f"b{at}{i}", names(f"y{at}{i}_", len(slab.along))
    inside = [f"const {T} {b} = s{at}{i} < {lo} ? {lo} : {hi};"]
    terms = [[(e, b)] for e in slab.base]
    if i:
        assert slab.plane is not None
        inside.append(f"{T} {', '.join(f'{e} = {zero}' for e in y)};")
        lower = [_less(f"lo{at}{j}", shift, b, c) for j, shift in enumerate(slab.shift)]
        upper = [_less(f"hi{at}{j}", shift, b, c) for j, shift in enumerate(slab.shift)]
        inside += _nearest(slab.plane, lower, upper, y, f"{at}{i}_", c)
        for coordinate, direction in zip(y, slab.along, strict=True):
            for axis, step in zip(terms, direction, strict=True):
                axis.append((step, coordinate))
    for name, axis in zip(z, terms, strict=True):
        inside.append(f"{name} = {dot([v for v, _ in axis], [n for _, n in axis], c)};")
    return [
        f"const {T} s{at}{i} = {s};",
        f"if (s{at}{i} < {lo} || s{at}{i} > {hi}) {{",
        *(f"    {line}" for line in inside),
        "}",
    ]


def _less(name: str, shift: float, b: str, c: Table) -> str:
    sign, text = _term(-shift, b, c)
    return f"({name} {'-' if sign else '+'} {text})" if shift else name


def _term(value: float, name: str, c: Table) -> tuple[bool, str]:
    return value < 0, name if abs(value) == 1.0 else f"{c(abs(value))} * {name}"


def _unless(condition: str) -> list[str]:
    return [f"if (!({condition})) {{", "    return INFEASIBLE;", "}"]


def _fold(function: str, terms: list[str]) -> str:
    """``most`` or ``least`` of any number of terms, as a tree: its depth is what a processor waits for."""
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return f"{function}({_fold(function, terms[:half])}, {_fold(function, terms[half:])})"
