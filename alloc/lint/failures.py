"""Cost of each failure of a single thruster."""

from collections.abc import Mapping
from math import comb
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from alloc.reach.attainable import FACETS, alpha_range
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import condition

INVOLVED = 0.3
"""Share of a lost direction's largest coefficient from which an axis is named, with rows of unit length."""


class Failure(NamedTuple):
    """A vehicle without one of its thrusters.

    Attributes
    ----------
    thruster : its index
    name : what people call it, empty where it has no name
    last : whether no thruster is left
    lost : the directions that nothing pushes any more, each by the axes that it couples
    condition : of T P over the rank that is left; see ``condition``
    left : of each axis, the share of its range that is left where only this axis is pushed
    """

    thruster: int
    name: str
    last: bool = False
    lost: tuple[tuple[str, ...], ...] = ()
    condition: float | None = None
    left: Mapping[str, float] = MappingProxyType({})

    @property
    def words(self) -> str:
        """Cost of the failure in words: ``no pitch``, ``no heave and roll together``, ``surge 50 %``."""
        if self.last:
            return "no thruster is left"
        if self.lost:
            said = [
                f"no {axes[0]}" if len(axes) == 1 else f"no {', '.join(axes[:-1])} and {axes[-1]} together"
                for axes in self.lost
            ]
            named = {axis for axes in self.lost for axis in axes}
            # A small coefficient names no axis, and still ties it to those that are lost.
            said += [
                f"no {axis} alone" for axis, share in self.left.items() if not share and axis not in named
            ]
            return ", ".join(said)
        axes = [f"{axis} {100 * share:.0f} %" for axis, share in self.left.items() if share < LITTLE]
        return f"{', '.join(axes)} of the range left" if axes else "every axis keeps its full range"


LITTLE = 0.995
"""Share of an axis's range from which a failure counts as costing nothing there."""


def failures(vehicle: Vehicle) -> list[Failure]:
    """Cost of the loss of each working thruster, one at a time."""
    axes = np.eye(vehicle.k)
    counted = comb(len(vehicle.working), max(vehicle.rank - 1, 0)) <= FACETS  # beyond, it takes minutes
    whole = _ranges(vehicle, axes) if counted else np.zeros(vehicle.k)
    found = []
    for i in vehicle.working.tolist():
        name = vehicle.names[i] if vehicle.names else ""
        try:
            degraded = vehicle.with_fault(i)
        except VehicleError:
            found.append(Failure(i, name, last=True))
            continue
        lost = [
            tuple(axis for axis, c in zip(vehicle.dof, direction, strict=True) if abs(c) >= INVOLVED)
            for direction in lost_directions(degraded, before=vehicle)
        ]
        left = {
            axis: float(after / before)
            for axis, before, after in zip(
                vehicle.dof, whole, _ranges(degraded, axes) if counted else whole, strict=True
            )
            if 0 < before < np.inf
        }
        found.append(Failure(i, name, False, tuple(lost), condition(degraded), left))
    return found


def lost_directions(vehicle: Vehicle, before: Vehicle | None = None) -> FloatArray:
    """(m, k) directions of wrench that no working thruster pushes, each with 1 as its largest entry.

    Coefficients refer to rows of T scaled to unit length. Directions are reduced, so that each has few axes.
    Given the same vehicle ``before`` a failure, directions that it lacked already are left out.
    """
    rows = _unpushed(vehicle)
    if before is not None and before.rank < before.k:
        known = _unpushed(before)
        rows = np.linalg.svd(rows - rows @ known.T @ known)[2][: before.rank - vehicle.rank]
    for i in range(len(rows)):  # row echelon form with the largest pivots
        j = int(np.argmax(np.abs(rows[i])))
        rows[i] /= rows[i, j]
        for other in range(len(rows)):
            if other != i:
                rows[other] -= rows[other, j] * rows[i]
    return rows


def _unpushed(vehicle: Vehicle) -> FloatArray:
    U = np.linalg.svd(vehicle.TP / vehicle.row_lengths[:, None])[0]
    return U[:, vehicle.rank :].T.copy()


def _ranges(vehicle: Vehicle, axes: FloatArray) -> FloatArray:
    low, high = alpha_range(vehicle, axes)
    return np.maximum(high - low, 0.0)
