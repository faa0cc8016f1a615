"""How far a vehicle and its methods reach, in numbers to draw: sections of the sets, errors over size."""

import numpy as np

from alloc import (
    Entry,
    Label,
    NotApplicable,
    Vehicle,
    alpha_max,
    build,
    closed_form_range,
    uniform_demands,
)
from alloc.allocation import FloatArray
from bench.demands import build_demands
from bench.loss import relative_wrench_error
from bench.worth import Curve, Plane

PLANES = (("surge", "sway"), ("surge", "yaw"))
"""Where a vehicle on its way needs thrust together: ahead and sideways, ahead and turning."""

ANGLES = 360
"""Rays an outline is made of: a corner is cut by less than a line is wide."""

POINTS = 150
"""Demands drawn in: enough to show where they lie, few enough to tell apart."""

SIZES = np.linspace(0.05, 2.0, 40)
"""Demand over the edge of the attainable set in its direction."""

DIRECTIONS = 100
"""Directions in which each size is tried."""


def planes(vehicle: Vehicle, seed: int) -> list[Plane]:
    """Sections of the attainable and the closed form's set, with a mission's demands; [] without those."""
    wanted = [(x, y) for x, y in PLANES if {x, y} <= set(vehicle.dof)]
    if not wanted:
        return []
    try:
        mission = build_demands("mission", vehicle, seed)
    except NotApplicable:
        return []
    pick = np.linspace(0, len(mission.taus) - 1, POINTS).astype(int)
    names = [Label(int(value)).name.lower() for value in mission.labels[pick]]
    angles = np.linspace(0.0, 2 * np.pi, ANGLES, endpoint=False)
    found = []
    for x, y in wanted:
        i, j = vehicle.dof.index(x), vehicle.dof.index(y)
        rays = np.zeros((ANGLES, vehicle.k))
        rays[:, i] = np.cos(angles) * vehicle.wrench_scale[i]
        rays[:, j] = np.sin(angles) * vehicle.wrench_scale[j]
        attainable, closed_form = (
            _pairs(reach[:, None] * rays[:, [i, j]])
            for reach in (alpha_max(vehicle, rays), closed_form_range(vehicle, rays)[1])
        )
        points = _pairs(mission.taus[pick][:, [i, j]])
        demands = [(a, b, name) for (a, b), name in zip(points, names, strict=True)]
        found.append(Plane(x, y, attainable, closed_form, demands))
    return found


def error_curve(vehicle: Vehicle, entry: Entry, rng: np.random.Generator) -> Curve | None:
    """Wrench error of one method over the size of the demand; None where it refuses the vehicle."""
    inside = uniform_demands(vehicle, rng, DIRECTIONS)
    edge = inside * alpha_max(vehicle, inside)[:, None]
    taus = (SIZES[:, None, None] * edge).reshape(-1, vehicle.k)
    try:
        F, _ = build(entry.name, vehicle).many(taus)
    except NotApplicable:
        return None
    error = relative_wrench_error(vehicle, taus, F).reshape(len(SIZES), DIRECTIONS)
    error = np.where(np.isnan(error), 1.0, error)  # no answer delivers nothing
    return Curve(
        entry.name,
        entry.formulation,
        SIZES.round(3).tolist(),
        np.median(error, axis=1).tolist(),
        error.max(axis=1).tolist(),
    )


def _pairs(points: FloatArray) -> list[tuple[float, float]]:
    return [(float(f"{a:.6g}"), float(f"{b:.6g}")) for a, b in points.tolist()]
