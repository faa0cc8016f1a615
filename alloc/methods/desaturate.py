"""Sequential desaturation: cut axes one after another, the least important first, until all thrusts fit."""

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.balance import balancing_step
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
    columns = [(axis, G[:, axis].tolist(), WEAK * float(np.abs(G[:, axis]).max())) for axis in order]

    def desaturate(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        passes = 0
        for axis, column, weak in columns:
            demand = float(tau[axis])
            share = 1.0
            for weight in (1.0, 0.5):
                step = weight * balancing_step(f, column, limits.pairs, weak)
                if step == 0.0 or demand == 0.0:
                    break
                kept = min(max(share + step / demand, 0.0), share)
                f = [x + (kept - share) * demand * c for x, c in zip(f, column, strict=True)]
                share = kept
                passes += 1
        return f, passes

    return Saturating(vehicle, FORMULATION, desaturate)
