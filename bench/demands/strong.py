"""Strong part of a vehicle and of demands on it: what is labelled, and what losses are counted of.

Where no direction is weak, but for those that no thruster pushes, all of it is the vehicle and the demands
themselves.
"""

from typing import NamedTuple

import numpy as np

from alloc import Vehicle, alpha_max
from alloc.allocation import FloatArray
from alloc.lint.failures import weak_axes
from alloc.reach.attainable import single_axis_maxima
from alloc.reach.way import step_maps
from alloc.reach.zonotope import farthest

KEPT = 0.5
"""Share of an axis that must be strong for a demand along it to be asked: of a weak axis a trace is left."""


def strong_vehicle(vehicle: Vehicle) -> Vehicle:
    """The vehicle without its weak directions; itself where none is pushed and weak."""
    return vehicle.strong if vehicle.weak_left.any() else vehicle


def strong_demands(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """Demands (N, k) without what they ask along weak directions, as methods with a share leave it out."""
    strong = strong_vehicle(vehicle)
    return taus if strong is vehicle else taus @ step_maps(strong, [strong.dof])[0].T


def across(vehicle: Vehicle, wrenches: FloatArray) -> FloatArray:
    """Wrenches (N, k) without what they have along directions that are weak or count in part."""
    left = (vehicle.counts < 1.0) & (np.arange(vehicle.k) < vehicle.rank)
    rows, unit = vehicle.directions.rows[left], vehicle.directions.scale
    rest: FloatArray = wrenches - wrenches @ rows.T @ (rows * unit**2)
    return rest


def unasked_weak_axes(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """Demands (N, k) with the same strong part that ask for nothing on the axes of weak directions.

    A pilot asks for surge and for no pitch. The strong vehicle makes a little pitch with its surge, and a
    demand for just that wrench would flatter methods that hold every axis at its demand.
    """
    strong = strong_vehicle(vehicle)
    if strong is vehicle:
        return taus
    rows, rest = vehicle.weak * vehicle.directions.scale, list(range(vehicle.k))
    for i in range(len(rows)):
        axis = int(np.argmax(np.abs(rows[i])))
        rest.remove(axis)
        rows -= np.outer(rows[:, axis] * (np.arange(len(rows)) > i), rows[i] / rows[i, axis])
    D = step_maps(strong, [strong.dof])[0]
    asked = np.zeros_like(taus)
    asked[:, rest] = taus @ (np.linalg.pinv(D[:, rest]) @ D).T
    return asked


def axis_maxima(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    """``single_axis_maxima`` (k,) of what is strong of each axis; 0 for an axis that is weak."""
    strong = strong_vehicle(vehicle)
    if strong is vehicle:
        return single_axis_maxima(vehicle)
    axes = strong_demands(vehicle, np.eye(vehicle.k))
    kept = np.diag(axes) >= KEPT
    forward, backward = alpha_max(strong, axes), alpha_max(strong, -axes)
    return np.where(kept, -backward, 0.0), np.where(kept, forward, 0.0)


class WeakDirection(NamedTuple):
    """A direction of wrench that is pushed, and weak or counted in part.

    Attributes
    ----------
    words : ``pitch (0.5 % left)``: its axes, its authority over that of the strongest direction, and the
        share to which it counts, if any
    bound : most that thrusts within limits make along it, moments over the rms arm [N]
    """

    words: str
    bound: float


def weak_directions(vehicle: Vehicle) -> list[WeakDirection]:
    """Directions that are weak or count in part, and are not lost."""
    found = []
    for each in weak_axes(vehicle):
        pushes = each.row @ vehicle.TP
        found.append(WeakDirection(each.words, float(farthest(vehicle, np.stack([pushes, -pushes])).max())))
    return found
