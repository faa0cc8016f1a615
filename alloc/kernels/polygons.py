"""The exact method as a program where thrusters turn: steps over sides of polygons, in one block."""

from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.errors import NotApplicable
from alloc.kernels.entry import (
    SeenArguments,
    all_thrusters,
    clamp_thrusts,
    closed_form,
    cover_arguments,
    lost_parts,
    refine,
    refuse,
)
from alloc.kernels.exact import THINNER, Piece, clamp_block, limit_excess, moves
from alloc.kernels.rules import wrench_missed
from alloc.kernels.steps import Ratios, Strip, Values
from alloc.kernels.tolerance import MOVED_ERROR, TOLERANCE, needs_refinement
from alloc.nullspace.region import THIN, Region, prepare
from alloc.nullspace.slabs import polygon_slabs, whole_basis
from alloc.nullspace.structure import Block, decompose
from alloc.program import Builder, Expression, Limits, Program, Scalar, clamp, most, size
from alloc.program.sums import dot, product, shared_sums, signed, snapped
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import SPARE, Azimuth
from alloc.vehicle.condition import excess_that_misses, wrench_doubt

STEPS_LIMIT = 1500
"""Most steps; each is written out and takes flash."""
INSIDE: dict[Scalar, float] = {"double": SPARE, "float": SPARE * 2.0**29}
"""Share of the largest limit by which steps keep off sides, so that rounding leaves thrusts inside [-]."""
Thrusts = dict[int, Expression]


def exact_in_polygons(vehicle: Vehicle, scalar: Scalar) -> Program:
    """Program of the exact optimum, eq. 4-5, within the vehicle's own polygons and limits.

    Thrusts that rounding leaves outside of a polygon are moved inside, and are an answer only where they make
    tau. Raises NotApplicable for too many steps.
    """
    builder = Builder(vehicle, "fixed", scalar)
    structure = decompose(vehicle)
    excess, x = lost_parts(builder, structure), closed_form(builder, structure.G)
    doubt = max(TOLERANCE[scalar], wrench_doubt(vehicle)) * vehicle.f_scale
    slack = min(doubt, excess_that_misses(vehicle, (1.0 if excess else 2.0) * MOVED_ERROR[scalar]))
    if needs_refinement(vehicle, scalar):
        x = refine(builder, structure.G, x)
    seen = SeenArguments(cover_arguments(structure.G), builder)
    seen.know(0, x)
    seen.add(vehicle.working.tolist(), "0")
    C, *far = polygon_slabs(vehicle)
    C, (low, high) = snapped(C), snapped(np.array(far))  # what differs by rounding is one number
    turns = np.arange(len(C)) >= len(C) - sum(len(azimuth.distinct) for azimuth in vehicle.turning)
    spare = INSIDE[scalar] * vehicle.f_scale
    low = low + spare * (turns & (low < 0.0))  # no force at all stays on sides that pass through it
    high = high - spare * (turns & (high > 0.0))
    rows = _slab_values(builder, C, x)
    limits = Limits(vehicle, "fixed", builder.graph, ends=(low, high))
    N = whole_basis(structure, vehicle.n)
    A = snapped(C @ N)
    if not N.shape[1]:
        for j in rows:
            excess += limit_excess(j, rows, limits, slack)
        refuse(builder, seen, excess, exact=True)
        return _final_program(builder, x, spare)
    region = prepare(A, slack, THINNER[scalar] if N.shape[1] == 1 else THIN)
    if region.worst_case_steps > STEPS_LIMIT:
        raise NotApplicable(
            f"generated C: each step is written out, here {region.worst_case_steps}, "
            f"more than {STEPS_LIMIT}; use fewer sides, or a qp/ method"
        )
    if region.d == 1:
        found, steps = _line_steps(builder, region, A, rows, limits)
        builder.compute(*found.before)
        refuse(builder, seen, [*excess, *found.excess], exact=True)
    else:
        refuse(builder, seen, excess, exact=True)
        steps = _seidel_steps(builder, region, A, rows, limits)
    shares = snapped(N @ np.linalg.inv(np.array(steps.normals)))
    return _final_program(
        builder,
        {i: signed([(False, each), *dot(shares[i].tolist(), steps.lengths)]) for i, each in x.items()},
        spare,
    )


class Steps(NamedTuple):
    """Normals of d slabs, and how far along each of these z has moved."""

    normals: list[FloatArray]
    lengths: list[Expression]


def _slab_values(builder: Builder, C: FloatArray, x: Thrusts) -> Thrusts:
    """C f of each slab."""
    terms = shared_sums(product(C[:, list(x)], [*x.values()], "pn").rows, "sn")[1]
    return {j: signed(row, builder.graph).named(f"n{j}") for j, row in enumerate(terms)}


def _line_steps(
    builder: Builder, region: Region, A: FloatArray, rows: Thrusts, limits: Limits
) -> tuple[Piece, Steps]:
    """Steps where z has one dimension, without branches: along the normal of all slabs."""
    found = clamp_block(builder, Block(np.arange(len(A)), A), region, rows, "0", limits, 0.0)
    return found, Steps([np.array(region.slabs[0].normal)], found.before[-1:])


def _seidel_steps(builder: Builder, region: Region, A: FloatArray, rows: Thrusts, limits: Limits) -> Steps:
    """Steps where z has more dimensions, by Seidel."""
    strips = [Strip(f"v{j}", normal, rows[j], *limits.ends(j)) for j, normal in enumerate(A)]
    values: Values = {strip.key: rows[j] for j, strip in enumerate(strips)}
    kept, moved = moves(builder, region, strips, values, "0", Ratios())
    return Steps([row.normal for row in kept], moved)


def _final_program(builder: Builder, thrusts: Thrusts, spare: float) -> Program:
    """The program that writes thrusts; those outside of a polygon are moved inside, if they then make tau."""
    vehicle = builder.vehicle
    turning = {i for azimuth in vehicle.turning for i in azimuth.components}
    fixed = {i: thrust for i, thrust in thrusts.items() if i not in turning}
    y = {i: thrust.named(f"y{i}") for i, thrust in thrusts.items() if i in turning}
    y |= clamp_thrusts(builder, fixed, builder.limits)
    builder.compute(*y.values())
    far = {azimuth: _beyond_sides(builder, azimuth, y) for azimuth in vehicle.turning}
    worst = most(*(each for sides in far.values() for each, _ in sides)).named("worst") if far else None
    if worst is None:
        return builder.program(all_thrusters(builder, y), Status.SOLVED)
    builder.compute(worst)
    with builder.where(worst > spare / 2, unlikely=True) as merged:
        inside = dict(y)
        for azimuth, sides in far.items():
            inwards = most(*((each + spare) * (1.0 / depth) for each, depth in sides))
            share = clamp(inwards, 0.0, 1.0).named(f"in{azimuth.first}")
            for i, middle in zip(azimuth.components, azimuth.middle.tolist(), strict=True):
                inside[i] = (y[i] + share * (middle - y[i])).named(f"z{i}")
        missed, allowed = wrench_missed(builder, inside)
        builder.refuse(~(missed <= allowed), Status.INFEASIBLE)
        y |= {i: merged(inside[i], y[i]) for i in y if i in turning}
    return builder.program(all_thrusters(builder, y), Status.SOLVED)


class _Side(NamedTuple):
    """Sides of a polygon that mirror one another: normal'v <= reach, of v = (x, |x|, y, |y|) of a force."""

    normal: tuple[float, float, float, float]
    reach: float


def _mirror_sides(azimuth: Azimuth) -> dict[_Side, float]:
    """The sides of a polygon, mirrored ones as one, each with the least depth of its middle [N]."""
    reach, depth = snapped(np.array([azimuth.reach, azimuth.depth]))
    ends = zip(snapped(azimuth.normals).tolist(), reach.tolist(), depth.tolist(), strict=True)
    found = {_Side((x, 0.0, y, 0.0), far): deep for (x, y), far, deep in ends}
    for axis in (2, 0):
        for side in list(found):
            (*normal,) = side.normal
            normal[axis] = -normal[axis]
            twin = _Side((normal[0], normal[1], normal[2], normal[3]), side.reach)
            if normal[axis] > 0.0 and twin in found:
                normal[axis : axis + 2] = 0.0, normal[axis]
                both = _Side((normal[0], normal[1], normal[2], normal[3]), side.reach)
                found[both] = min(found.pop(side), found.pop(twin))
    return found


def _beyond_sides(builder: Builder, azimuth: Azimuth, y: Thrusts) -> list[tuple[Expression, float]]:
    """Distance of a force beyond sides that are as far from zero, and the least depth of the middle [N]."""
    first, sides = azimuth.first, _mirror_sides(azimuth)
    into = [each for i in azimuth.components for each in (y[i], size(y[i]).named(f"size{i}"))]
    products = product(np.array([side.normal for side in sides]), into, f"q{first}_")
    rows = shared_sums(products.rows, f"w{first}_")[1]
    alike: dict[float, list[tuple[Expression, float]]] = {}
    for (side, depth), row in zip(sides.items(), rows, strict=True):
        alike.setdefault(side.reach, []).append((signed(row, builder.graph), depth))
    return [
        (
            most(*(value for value, _ in each)) - reach if reach else most(*(value for value, _ in each)),
            min(depth for _, depth in each),
        )
        for reach, each in alike.items()
    ]
