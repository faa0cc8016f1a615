"""A kernel's last step: thrusts that rounding spoilt are reduced, with the shares, until they agree again.

T p is what the shares say whatever z is, so an answer misses its wrench by what its thrusts p are moved onto
limits: by rounding, unless facets or rows that all but depend on each other magnified that. With thrusts c
inside the limits that make the wrench at rest, p - (1 - s) (p - c) makes what s times the shares say, for
any s. So where thrusts would be moved by more, s is taken so small that none is.
"""

from math import ceil, log2
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.kernels.tolerance import met_as_calculated
from alloc.kernels.walk import Walk
from alloc.nullspace.allocator import exact
from alloc.nullspace.structure import decompose
from alloc.program import Builder, Expression, Limits, Number, least, most, select, size
from alloc.program.sums import gathered, signed
from alloc.reach.edge import start
from alloc.vehicle import Vehicle

INSET = (1 / 4, 1 / 8, 1 / 16, 1 / 32, 1 / 64)
"""Distances from the limits at which thrusts at rest shall lie, as shares of their width, tried in turn."""
NARROW = 1e-20
"""A room that is smaller than this share of the largest limit is none."""
HUGE = 1e18
"""Thrusts that go so many times beyond the room are at rest behind that."""


class Gap(NamedTuple):
    """Distances of thrusts beyond limits.

    Attributes
    ----------
    value : not above zero where they lie inside
    moved : thruster i lies beyond by no more than ``moved[i]`` times the value
    """

    value: Expression
    moved: dict[int, float]


def beyond(builder: Builder, i: int, thrust: Expression, limits: Limits) -> Gap:
    """Gap of one thruster; zero if the thruster is off: scaling back can't help."""
    # Of a thruster that is off rounding alone is left: limits of no fault do, unless they leave out zero.
    low, high = (limits.of_no_fault() if limits.by_fault else limits).ends(i)
    same = isinstance(high, float) and low == -high
    value: Expression = size(thrust) - high if same else most(low - thrust, thrust - high)
    zero = isinstance(low, float) and isinstance(high, float) and low <= 0.0 <= high
    if not zero and any(state.readiness[i] == 0 for state in builder.faults.values()):
        on = builder.graph.by_fault(float(state.readiness[i] > 0) for state in builder.faults.values())
        value = on * value
    return Gap(value.named(f"beyond{i}"), {i: 1.0})


class Held(NamedTuple):
    """Thrusts by thruster before they are cut at limits, and the shares that they make."""

    thrusts: dict[int, Expression]
    shares: list[Expression]


def held(
    builder: Builder,
    gaps: list[Gap],
    thrusts: dict[int, Expression],
    walk: Walk,
    limits: Limits,
) -> Held:
    """Steps that draw thrusts in where they would miss by more than they may what the walk's shares say.

    Where all shares together are no factor of what they make, thrusts are at rest then.
    """
    shares, (units, spare) = walk.shares, _units(builder, gaps)
    if not units:
        return Held(thrusts, shares)
    bound = max(units)
    each = [(bound / unit) * most(*(gap.value for gap in alike)) for unit, alike in units.items()]
    worst: Expression = most(*each).named("worst")
    builder.compute(worst)
    with builder.where(worst > bound, unlikely=True) as merged:
        center = _center(builder, walk)
        if not walk.proportional:
            drawn = {i: merged(center[i], thrust) for i, thrust in thrusts.items()}
            return Held(_named(drawn), [merged(0.0, share) for share in shares])
        rooms, taken = _rooms(builder, center, limits), list[Number]([HUGE])
        if rooms:  # no more than what the largest gap takes of the narrowest room
            taken.append((spare / bound) * (worst - bound) * (1.0 / min(rooms.values())))
        if len({*rooms.values()}) != 1:
            outside = {i: beyond(builder, i, x, limits).value for i, x in thrusts.items()}
            gone = {i: value - spare for i, value in outside.items()}
            ahead: dict[int, Number] = {**rooms}
            for i, x in thrusts.items() if not rooms else ():
                ahead[i] = _room(x, center[i], limits.ends(i)) + spare
            taken.append(most(*(over(value, ahead[i]) for i, value in gone.items())))
            # c may lie at a limit of the call; but what all miss shrinks as all are drawn in.
            if limits.at_call and _magnified(builder):
                taken.append(_missed(builder, outside) - 1.0)
        more = most(least(*taken[::-1]), 0.0)
        kept = (1.0 / (1.0 + more)).named("kept")
        lost = (1.0 - kept).named("lost")
        builder.compute(kept, lost)
        drawn = {}
        for i, x in thrusts.items():
            away = x if center[i] == 0.0 else x - center[i]
            drawn[i] = merged(x - lost * away, x)
        return Held(_named(drawn), [merged(share * kept, share) for share in shares])


def over(value: Expression, room: Number) -> Expression:
    """value / room."""
    return value / room if isinstance(room, Expression) else value * (1.0 / room)


def _named(drawn: dict[int, Expression]) -> dict[int, Expression]:
    return {i: x.named(f"in{i}") for i, x in drawn.items()}


def _units(builder: Builder, gaps: list[Gap]) -> tuple[dict[float, list[Gap]], float]:
    """Gaps by what they may be, and how far every thruster may lie beyond a limit [N].

    Gaps g_j miss an axis by no more than sum_j g_j sum_i |T_i| moved_ij, which may be half of what SOLVED may
    miss. So that few units differ each g_j may be as large as any other, but for those that take thrusts
    beyond by much less.
    """
    vehicle = builder.vehicle
    A = np.abs(vehicle.TP) / vehicle.wrench_scale[:, None]
    missed, units = np.zeros(vehicle.k), dict[float, list[Gap]]()
    for gap in gaps:
        unit = 2.0 ** -ceil(log2(max(gap.moved.values())))  # a product with a power of two is exact
        missed += A[:, list(gap.moved)] @ list(gap.moved.values()) * unit
        units.setdefault(unit, []).append(gap)
    largest = missed.max(initial=0.0)
    if not largest > 0.0:
        return {}, 0.0
    spare = float(met_as_calculated(vehicle, builder.scalar) / 2 / largest)
    return {spare * unit: found for unit, found in units.items()}, spare


def _magnified(builder: Builder) -> bool:
    """True if steps in single precision may carry thrusts farther beyond limits than is permitted."""
    blocks = decompose(builder.vehicle).blocks
    return builder.scalar == "float" and any(block.N.shape[1] > 1 for block in blocks)


def _missed(builder: Builder, outside: dict[int, Expression]) -> Expression:
    """Wrench error of thrusts so far outside of limits [N], over half of what SOLVED may miss."""
    vehicle = builder.vehicle
    A = np.abs(vehicle.TP) / vehicle.wrench_scale[:, None]
    by = A.max(axis=0)[list(outside)] / (met_as_calculated(vehicle, builder.scalar) / 2)
    (row,) = gathered(by[None], [most(value, 0.0) for value in outside.values()], "o")
    return signed(row, builder.graph).named("missed")


def _rooms(builder: Builder, center: dict[int, Number], limits: Limits) -> dict[int, float]:
    """Room of each thrust of c to the nearer limit; empty where one has none, or it is not known."""
    found: dict[int, float] = {}
    for i, c in center.items():
        low, high = limits.ends(i)
        if isinstance(low, Expression) or isinstance(high, Expression) or isinstance(c, Expression):
            return {}
        found[i] = min(high - c, c - low)
    return found if min(found.values()) > NARROW * builder.vehicle.f_scale else {}


def _room(thrust: Expression, c: Number, ends: tuple[Number, Number]) -> Expression:
    """Distance from c to the limit on the thrust's side. On the other side c may lie at the limit."""
    low, high = ends
    room: Expression = most(select(thrust > c, high - c, c - low), 0.0)
    return room


def _center(builder: Builder, walk: Walk) -> dict[int, Number]:
    """c of each working thruster."""
    vehicle = builder.vehicle
    if builder.limits.by_fault:
        each = np.array([at_rest(state) for state in builder.faults.values()])
        return {i: builder.graph.by_fault(each[:, i]) for i in vehicle.working.tolist()}
    c: list[Number] = walk.start if builder.limits.at_call else list(at_rest(vehicle))
    return {i: c[i] for i in vehicle.working.tolist()}


def at_rest(vehicle: Vehicle) -> FloatArray:
    """(n,) thrusts that make what the start makes, inside the vehicle's limits as far as INSET asks."""
    ready = vehicle.readiness > 0
    f0 = np.where(ready, start(vehicle.f_min, vehicle.f_max), 0.0)
    low = np.where(ready, vehicle.f_min, -vehicle.f_scale)
    high = np.where(ready, vehicle.f_max, vehicle.f_scale)
    allocate = exact(vehicle)
    for inset in INSET:
        by = inset * (high - low)
        pairs = list(zip((low + by).tolist(), (high - by).tolist(), strict=True))
        found = allocate.within(vehicle.TP @ f0, pairs)
        if found.status is Status.SOLVED:
            return found.f
    return f0
