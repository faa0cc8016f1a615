"""Last step of a kernel: scale thrusts and shares back until the limits no longer change the wrench.

Thrusts p make the wrench that the shares promise. Cutting p at the limits changes it: by rounding, or by
more where nearly dependent facets or rows magnified rounding. Let c be thrusts inside the limits that make
the wrench of no demand. Then p - (1 - s) (p - c) makes s times the promised shares for any s, and s is
chosen so small that no thrust is cut by more than the tolerance.
"""

from math import ceil, log2
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.kernels.tolerance import computed_error_limit
from alloc.kernels.walk import Walk
from alloc.nullspace.allocator import exact
from alloc.nullspace.structure import decompose
from alloc.program import Builder, Expression, Limits, Number, least, most, select, size
from alloc.program.sums import gathered, signed
from alloc.reach.edge import start
from alloc.vehicle import Vehicle

INSET = (1 / 4, 1 / 8, 1 / 16, 1 / 32, 1 / 64)
"""Distances of the thrusts c from the limits, as fractions of the width between them, tried in turn [-]."""
NARROW = 1e-20
"""Room below this fraction of the largest limit counts as none [-]."""
HUGE = 1e18
"""Ratio of excess to room from which thrusts are set to c [-]."""


class Gap(NamedTuple):
    """Excess of some thrusts over their limits.

    Attributes
    ----------
    value : the excess [N]; at most zero inside the limits
    reach : by thruster, its own excess over ``value``, at most [-]
    """

    value: Expression
    reach: dict[int, float]


def limit_gap(builder: Builder, i: int, thrust: Expression, limits: Limits) -> Gap:
    """Gap of one thruster; zero if the thruster is off: scaling back can't help."""
    # A failed thruster's thrust is zero but for rounding, so the healthy limits serve if they contain zero.
    low, high = (limits.of_no_fault() if limits.by_fault else limits).ends(i)
    same = isinstance(high, float) and low == -high
    value: Expression = size(thrust) - high if same else most(low - thrust, thrust - high)
    zero = isinstance(low, float) and isinstance(high, float) and low <= 0.0 <= high
    if not zero and any(state.readiness[i] == 0 for state in builder.faults.values()):
        on = builder.graph.by_fault(float(state.readiness[i] > 0) for state in builder.faults.values())
        value = on * value
    return Gap(value.named(f"beyond{i}"), {i: 1.0})


class Correction(NamedTuple):
    """Thrusts by thruster before the cut at the limits, and the shares that they deliver."""

    thrusts: dict[int, Expression]
    shares: list[Expression]


def correct_thrusts(
    builder: Builder,
    gaps: list[Gap],
    thrusts: dict[int, Expression],
    walk: Walk,
    limits: Limits,
) -> Correction:
    """Scale thrusts and shares back where the cut at the limits would break the promised shares.

    If the wrench is not proportional to the shares, the thrusts become c and the shares zero.
    """
    shares, (units, spare) = walk.shares, _group_gaps(builder, gaps)
    if not units:
        return Correction(thrusts, shares)
    bound = max(units)
    each = [(bound / unit) * most(*(gap.value for gap in alike)) for unit, alike in units.items()]
    worst: Expression = most(*each).named("worst")
    builder.compute(worst)
    with builder.where(worst > bound, unlikely=True) as merged:
        center = _center(builder, walk)
        if not walk.proportional:
            drawn = {i: merged(center[i], thrust) for i, thrust in thrusts.items()}
            return Correction(_name_thrusts(drawn), [merged(0.0, share) for share in shares])
        rooms, taken = _rooms(builder, center, limits), list[Number]([HUGE])
        if rooms:  # the largest gap over the narrowest room
            taken.append((spare / bound) * (worst - bound) * (1.0 / min(rooms.values())))
        if len({*rooms.values()}) != 1:
            outside = {i: limit_gap(builder, i, x, limits).value for i, x in thrusts.items()}
            gone = {i: value - spare for i, value in outside.items()}
            ahead: dict[int, Number] = {**rooms}
            for i, x in thrusts.items() if not rooms else ():
                ahead[i] = _room(x, center[i], limits.ends(i)) + spare
            taken.append(most(*(quotient(value, ahead[i]) for i, value in gone.items())))
            # c may lie at a limit of the call; the total wrench error still shrinks with s.
            if limits.at_call and _may_magnify(builder):
                taken.append(_wrench_error(builder, outside) - 1.0)
        more = most(least(*taken[::-1]), 0.0)
        kept = (1.0 / (1.0 + more)).named("kept")
        lost = (1.0 - kept).named("lost")
        builder.compute(kept, lost)
        drawn = {}
        for i, x in thrusts.items():
            away = x if center[i] == 0.0 else x - center[i]
            drawn[i] = merged(x - lost * away, x)
        return Correction(_name_thrusts(drawn), [merged(share * kept, share) for share in shares])


def quotient(value: Expression, room: Number) -> Expression:
    """value / room."""
    return value / room if isinstance(room, Expression) else value * (1.0 / room)


def _name_thrusts(drawn: dict[int, Expression]) -> dict[int, Expression]:
    return {i: x.named(f"in{i}") for i, x in drawn.items()}


def _group_gaps(builder: Builder, gaps: list[Gap]) -> tuple[dict[float, list[Gap]], float]:
    """Gaps grouped by their allowance, and the allowed excess of a thruster over its limit [N].

    Gaps g_j change an axis of the wrench by at most sum_j g_j sum_i |T_i| reach_ij, of which half the error
    of a SOLVED wrench is allowed. The allowance of g_j is rounded to a power of two of its largest reach, so
    that there are few groups.
    """
    vehicle = builder.vehicle
    A = np.abs(vehicle.TP) / vehicle.wrench_scale[:, None]
    missed, units = np.zeros(vehicle.k), dict[float, list[Gap]]()
    for gap in gaps:
        unit = 2.0 ** -ceil(log2(max(gap.reach.values())))  # a product with a power of two is exact
        missed += A[:, list(gap.reach)] @ list(gap.reach.values()) * unit
        units.setdefault(unit, []).append(gap)
    largest = missed.max(initial=0.0)
    if not largest > 0.0:
        return {}, 0.0
    spare = float(computed_error_limit(vehicle, builder.scalar) / 2 / largest)
    return {spare * unit: found for unit, found in units.items()}, spare


def _may_magnify(builder: Builder) -> bool:
    """True if single precision may carry thrusts beyond the limits by more than the allowance."""
    blocks = decompose(builder.vehicle).blocks
    return builder.scalar == "float" and any(block.N.shape[1] > 1 for block in blocks)


def _wrench_error(builder: Builder, outside: dict[int, Expression]) -> Expression:
    """Wrench error of these excesses [N], over half the error allowed of a SOLVED wrench [-]."""
    vehicle = builder.vehicle
    A = np.abs(vehicle.TP) / vehicle.wrench_scale[:, None]
    by = A.max(axis=0)[list(outside)] / (computed_error_limit(vehicle, builder.scalar) / 2)
    (row,) = gathered(by[None], [most(value, 0.0) for value in outside.values()], "o")
    return signed(row, builder.graph).named("missed")


def _rooms(builder: Builder, center: dict[int, Number], limits: Limits) -> dict[int, float]:
    """Distance of each thrust of c to its nearer limit [N]; empty where one is zero or not a constant."""
    found: dict[int, float] = {}
    for i, c in center.items():
        low, high = limits.ends(i)
        if isinstance(low, Expression) or isinstance(high, Expression) or isinstance(c, Expression):
            return {}
        found[i] = min(high - c, c - low)
    return found if min(found.values()) > NARROW * builder.vehicle.f_scale else {}


def _room(thrust: Expression, c: Number, ends: tuple[Number, Number]) -> Expression:
    """Distance from c to the limit on the thrust's side [N]."""
    low, high = ends
    room: Expression = most(select(thrust > c, high - c, c - low), 0.0)
    return room


def _center(builder: Builder, walk: Walk) -> dict[int, Number]:
    """Thrusts c by working thruster [N]."""
    vehicle = builder.vehicle
    if builder.limits.by_fault:
        each = np.array([rest_thrusts(state) for state in builder.faults.values()])
        return {i: builder.graph.by_fault(each[:, i]) for i in vehicle.working.tolist()}
    c: list[Number] = walk.start if builder.limits.at_call else list(rest_thrusts(vehicle))
    return {i: c[i] for i in vehicle.working.tolist()}


def rest_thrusts(vehicle: Vehicle) -> FloatArray:
    """Thrusts c (n,) that make the wrench of the start, as far inside the limits as INSET allows [N]."""
    ready = vehicle.readiness > 0
    f0 = np.where(ready, start(vehicle.f_min, vehicle.f_max), 0.0)
    low = np.where(ready, vehicle.f_min, -vehicle.f_scale)
    high = np.where(ready, vehicle.f_max, vehicle.f_scale)
    allocate = exact(vehicle)
    for inset in INSET:
        by = inset * (high - low)
        pairs = list(zip((low + by).tolist(), (high - by).tolist(), strict=True))
        found = allocate.solve(vehicle.TP @ f0, pairs)
        if found.status is Status.SOLVED:
            return found.f
    return f0
