"""Answers that say force and angle of each thruster that turns, whatever method they are of."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import Allocation, Allocator
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import polar

OFFERED = ("pose", "solve", "worst_case_steps")
"""Parts of an allocator by which its kind is told (``alloc.plugin.TwoStage``, ``BoundedSteps``)."""


def with_angles(vehicle: Vehicle, given: Allocation) -> Allocation:
    """An answer with ``forces`` and ``angles`` out of its ``f``, and the ``middles`` of sectors."""
    said = polar(vehicle.azimuths, vehicle.actuators, given.f.tolist(), vehicle.f_scale)
    forces, angles, middles = map(np.array, said)
    return given._replace(forces=forces, angles=angles, middles=middles)


class AzimuthAllocator:
    """An allocator of a vehicle whose thrusters turn: another's answers, with forces and angles."""

    def __init__(self, allocator: Allocator, vehicle: Vehicle) -> None:
        """Wrap the allocator of any method."""
        self._allocator, self._vehicle = allocator, vehicle
        self.formulation, self.limited = allocator.formulation, allocator.limited
        self.tolerance = allocator.tolerance
        self.many: Any = getattr(allocator, "many", None)
        self.__dict__ |= {name: getattr(allocator, name) for name in OFFERED if hasattr(allocator, name)}

    def __call__(self, tau: ArrayLike, *limits: ArrayLike | None, **given: Any) -> Allocation:
        """Allocate one wrench (k,) [N, N m] as the other does, and say forces and angles."""
        found = self._allocator(tau, *limits, **given)
        if isinstance(found, Allocation) and np.shape(found.f) == (self._vehicle.n,):
            return with_angles(self._vehicle, found)
        return found  # a plug-in's answer that is none: what holds it to its promises says so
