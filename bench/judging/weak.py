"""Cost of weak directions on one vehicle: what methods make of a demand along one axis."""

import numpy as np

from alloc import AllocError, Status, Vehicle, alpha_max, build
from alloc.vehicle.geometry import unit
from bench.demands.strong import axis_maxima, strong_vehicle, weak_directions
from bench.judging.judge import rounded
from bench.record import AxisCost

METHODS = ("scaled", "priority", "nullspace", "clip")
"""One method for each way to treat a weak direction: it is left out, held at its demand, or missed."""
HALF = 0.5
"""Demand along an axis, of the most that the strong part makes along it: nobody needs to saturate [-]."""
NEARLY = 0.999
"""Share of the most under eq. 4-5 at which its thrusts are looked at: rounding must not refuse it."""


def axis_costs(vehicle: Vehicle) -> list[AxisCost]:
    """Cost on each axis that is not weak itself; empty for a vehicle without weak directions.

    Both eq. 4-5 and the closed forms behind ``clip`` hold a weak direction at what is asked of it, nothing.
    """
    if strong_vehicle(vehicle) is vehicle:
        return []
    allocators = {}
    for method in METHODS:
        try:
            allocators[method] = build(method, vehicle)
        except AllocError:  # too many facets, for instance
            continue
    costs = []
    backward, forward = axis_maxima(vehicle)
    for i, (axis, most) in enumerate(zip(vehicle.dof, np.maximum(forward, -backward), strict=True)):
        if not most > 0.0:
            continue
        way = np.eye(vehicle.k)[i] * (1.0 if forward[i] >= -backward[i] else -1.0)
        tau = HALF * most * way
        hard = max(float(alpha_max(vehicle, way[None])[0]), 0.0)
        at_most = allocators["nullspace"](NEARLY * hard * way).f if "nullspace" in allocators else np.nan
        cost = AxisCost(axis=axis, demand=rounded(HALF * most), hard_most=rounded(hard))
        if hard > 0.0 and np.isfinite(at_most).all():
            cost.hard_thrust_N = rounded(np.abs(at_most).max())
        for method, allocate in allocators.items():
            answer = allocate(tau)
            if answer.status not in (Status.SOLVED, Status.PARTIAL):
                cost.wrench[method] = cost.thrust_N[method] = None
                continue
            cost.wrench[method] = rounded((vehicle.TP @ answer.f)[i] * way[i])
            cost.thrust_N[method] = rounded(np.abs(answer.f).max())
        costs.append(cost)
    return costs


def weak_lines(vehicle: Vehicle) -> list[str]:
    """Lines of ``thrustbench check`` on weak directions: each bound, then each axis by method."""
    lines = [
        f"weak     {each.words}: thrusts within limits make at most {each.bound:.3g} N along it"
        for each in weak_directions(vehicle)
    ]
    for cost in axis_costs(vehicle):
        words = "; ".join(f"{method} {cost.words(method, unit(cost.axis))}" for method in cost.wrench)
        lines.append(f"weak     {cost.axis} {cost.demand:.3g} {unit(cost.axis)}: {words}")
    return lines
