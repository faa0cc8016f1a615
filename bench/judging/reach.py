"""How far a vehicle and its methods reach, in numbers to draw: sections of sets, and errors over size."""

from dataclasses import replace

import numpy as np

from alloc import Label, NotApplicable, Vehicle, alpha_max
from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.reach.attainable import closed_form_range, single_axis_maxima
from alloc.reach.volumes import uniform_demands
from bench.demands import DemandSet, build_demands
from bench.demands.store import Case
from bench.judging.loss import relative_wrench_error
from bench.record import Curve, Plane

PLANES = (("surge", "sway", "yaw"), ("surge", "yaw", "sway"))
"""The two axes of each section, and the third that is held. A vehicle under way needs thrust ahead and
sideways, or ahead and turning, at once; the third axis decides how much of that is left."""

HELD = (0.0, 0.4)
"""Where the third axis is held, as a share of what that axis reaches alone. Along two axes at a time a
closed form loses nothing on a symmetric vehicle; along three it does."""

ANGLES = 360
"""Rays that trace an outline; a side that spans less than two degrees may be missed."""

STRAIGHT = 1e-6
"""Sine of the turn below which points count as in line: rounding leaves 1e-12, corners turn by degrees."""

POINTS = 150
"""Demands drawn into a section: enough to show where they lie, few enough to tell apart."""

SIZES = np.linspace(0.05, 2.0, 40)
"""Demand over the edge of the attainable set in its direction."""

DIRECTIONS = 100
"""Directions in which each size is tried."""


def planes(vehicle: Vehicle, seed: int) -> list[Plane]:
    """Sections of the attainable set and of where the closed form keeps the limits, for each of HELD in turn.

    Empty for a vehicle without these axes, or that can't fly the mission. A section in which the vehicle
    can't push every way, as after a failure or where thrusters can't reverse, is left out.
    """
    wanted = [axes for axes in PLANES if set(axes) <= set(vehicle.dof)]
    if not wanted:
        return []
    try:
        mission = build_demands("mission", vehicle, seed)
    except NotApplicable:
        return []
    _, forward = single_axis_maxima(vehicle)
    sections = []
    for share in HELD:
        for x, y, held in wanted:
            i, j, third = (vehicle.dof.index(axis) for axis in (x, y, held))
            at = float(share * forward[third])
            attainable, closed_form = _outlines(vehicle, i, j, third, at)
            if attainable:
                drawn = [] if share else _drawn(mission, i, j)
                sections.append(
                    Plane(
                        x=x,
                        y=y,
                        held=held,
                        held_at=at,
                        attainable=attainable,
                        closed_form=closed_form,
                        demands=drawn,
                    )
                )
    return sections


def _outlines(
    vehicle: Vehicle, i: int, j: int, third: int, at: float
) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Corners of the attainable and the closed form's outline in axes i and j, the third axis at ``at``."""
    angles = np.linspace(0.0, 2 * np.pi, ANGLES, endpoint=False)
    rays = np.zeros((ANGLES, vehicle.k))
    rays[:, i] = np.cos(angles) * vehicle.wrench_scale[i]
    rays[:, j] = np.sin(angles) * vehicle.wrench_scale[j]
    start = np.zeros(vehicle.k)
    start[third] = at
    # Limits less T* start: both sets are moved so that start is their zero.
    given = generalized_inverse(vehicle) @ start
    moved = replace(vehicle, f_min=vehicle.f_min - given, f_max=vehicle.f_max - given)
    attainable, closed_form = (
        # Rays from outside a set or from its edge reach only part of its outline.
        _pairs(corners(reach[:, None] * rays[:, [i, j]])) if (reach > 0).all() else []
        for reach in (alpha_max(moved, rays), closed_form_range(moved, rays)[1])
    )
    return attainable, closed_form


def corners(edge: FloatArray) -> FloatArray:
    """Corners (m, 2) of the convex polygon whose edge passes through the points (n, 2), in order.

    Three or more points in line show a side; corners are where neighbouring sides meet.
    """
    size = np.abs(edge).max(axis=0)
    points = edge / size
    steps = np.roll(points, -1, axis=0) - points
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    turns = np.abs(cross(np.roll(steps, 1, axis=0), steps)) > STRAIGHT  # at each point
    on_side = ~turns | ~np.roll(turns, -1)
    first = on_side & (turns | ~np.roll(on_side, 1))  # the first step of each side
    p, d = points[first], steps[first]
    q, e = np.roll(p, -1, axis=0), np.roll(d, -1, axis=0)
    along = cross(q - p, e) / cross(d, e)
    met: FloatArray = (p + along[:, None] * d) * size
    return met


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a x b of plane vectors (n, 2): the sine of the angle between them where both are of unit length."""
    sine: FloatArray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return sine


def _drawn(mission: DemandSet, i: int, j: int) -> list[tuple[float, float, str]]:
    pick = np.linspace(0, len(mission.taus) - 1, POINTS).astype(int)
    names = [Label(int(value)).name.lower() for value in mission.labels[pick]]
    points = _pairs(mission.taus[pick][:, [i, j]])
    return [(x, y, name) for (x, y), name in zip(points, names, strict=True)]


def demands_of_growing_size(vehicle: Vehicle, rng: np.random.Generator) -> FloatArray:
    """Demands (N, k) [N, N m]: each of SIZES in DIRECTIONS directions, size by size; size 1 is the edge."""
    inside = uniform_demands(vehicle, rng, DIRECTIONS)
    edge = inside * alpha_max(vehicle, inside)[:, None]
    return (SIZES[:, None, None] * edge).reshape(-1, vehicle.k)


def error_curve(method: str, case: Case, F: FloatArray) -> Curve:
    """Wrench error of a method's thrusts F (N, n) for a case of ``demands_of_growing_size``."""
    error = relative_wrench_error(case.vehicle, case.taus, F).reshape(len(SIZES), DIRECTIONS)
    error = np.where(np.isnan(error), 1.0, error)  # without thrusts nothing is delivered
    return Curve(
        method=method,
        size=SIZES.round(3).tolist(),
        error_p50=np.median(error, axis=1).tolist(),
        error_max=error.max(axis=1).tolist(),
    )


def _pairs(points: FloatArray) -> list[tuple[float, float]]:
    return [(float(f"{a:.6g}"), float(f"{b:.6g}")) for a, b in points.tolist()]
