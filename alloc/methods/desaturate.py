"""Sequential desaturation: cut axes one after another, the least important first, until all thrusts fit."""

from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.vehicle import Vehicle

FORMULATION = "desaturate"

CUT_ORDER = ("sway", "surge", "yaw", "heave", "pitch", "roll")
"""Axes, the first to be cut first. A vehicle that tips over controls nothing, so roll and pitch are cut last
and yaw before heave, as PX4's multicopter mixing does; surge and sway, which that seldom has, go first."""

WEAK = 0.2
"""A thruster with less than this share of an axis's largest thrust is not brought inside by that axis:
moving it a little would cost all of the axis (PX4 leaves out the same share)."""


def build(vehicle: Vehicle) -> Saturating:
    """Prepare f = T* (tau with axes scaled down one by one).

    After the idea of PX4's ControlAllocationSequentialDesaturation: for each axis in turn move along
    its column of T*, by the step that brings the worst thruster to its limit (the sum of the two extreme
    steps where they oppose each other), then by half of a second such step. Here an axis may only lose:
    its share of the demand stays between 0 and 1.
    """
    G = generalized_inverse(vehicle)
    order = [vehicle.dof.index(axis) for axis in CUT_ORDER if axis in vehicle.dof]
    columns = [(axis, G[:, axis].tolist()) for axis in order]

    def desaturate(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        passes = 0
        for axis, column in columns:
            demand = float(tau[axis])
            share = 1.0
            for weight in (1.0, 0.5):
                step = weight * _step(f, column, limits.pairs)
                if step == 0.0 or demand == 0.0:
                    break
                kept = min(max(share + step / demand, 0.0), share)
                f = [x + (kept - share) * demand * c for x, c in zip(f, column, strict=True)]
                share = kept
                passes += 1
        return f, passes

    return Saturating(vehicle, FORMULATION, desaturate)


def _step(f: list[float], column: list[float], limits: list[tuple[float, float]]) -> float:
    """Amount of the axis to add [N, N m] so that the worst excess on either side is balanced; 0 if none."""
    weak = WEAK * max(map(abs, column))
    least = most = 0.0
    for x, c, (low, high) in zip(f, column, limits, strict=True):
        if low <= x <= high or abs(c) <= weak:
            continue
        step = ((low if x < low else high) - x) / c
        least, most = min(least, step), max(most, step)
    return least + most
