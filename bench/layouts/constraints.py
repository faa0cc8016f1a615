"""Which layouts keep to a study's constraints."""

import numpy as np

from alloc.allocation import BoolArray
from bench.layouts.space import PlacedThrusters
from bench.layouts.study import Constraints, Wake


def refused(poses: PlacedThrusters, constraints: Constraints) -> dict[str, BoolArray]:
    """For each constraint, by its key in the file, which layouts (B,) break it."""
    position = poses.position
    broken: dict[str, BoolArray] = {}
    for axis, ends in enumerate((constraints.box.x, constraints.box.y, constraints.box.z)):
        if ends is not None:
            least, largest = position[:, axis].min(axis=0), position[:, axis].max(axis=0)
            broken[f"box.{'xyz'[axis]}"] = (least < ends[0] - ROUNDING) | (largest > ends[1] + ROUNDING)
    first, second = np.triu_indices(len(position), 1)
    if constraints.distance > 0:
        apart = np.sqrt(((position[first] - position[second]) ** 2).sum(axis=1))
        broken["distance"] = (apart < constraints.distance - ROUNDING).any(axis=0)
    if constraints.wake is not None:
        broken["wake"] = _in_a_wake(poses, constraints.wake)
    return broken


ROUNDING = 1e-12
"""Metres that do not count: an end of the box is inside."""


def _in_a_wake(poses: PlacedThrusters, wake: Wake) -> BoolArray:
    """Whether a thruster sits in another one's jet, which leaves against the thrust, also in reverse."""
    n, _, count = poses.position.shape
    hit = np.zeros(count, dtype=bool)
    widening = np.tan(np.radians(wake.spread_deg))
    for i in range(n):
        to = np.delete(poses.position, i, axis=0) - poses.position[i]
        along = (to * poses.direction[i]).sum(axis=1)
        aside = np.sqrt(np.maximum((to**2).sum(axis=1) - along**2, 0.0))
        ahead, astern = poses.f_min[i] < 0, poses.f_max[i] > 0
        downstream = np.where(along > 0, ahead, astern) & (np.abs(along) <= wake.length)
        hit |= (downstream & (aside < wake.radius + np.abs(along) * widening)).any(axis=0)
    return hit
