"""Cost of a vehicle's own mixer: what it delivers of demands that its thrusters can meet."""

from collections.abc import Iterator

import numpy as np

from alloc import Allocator, AllocError, Vehicle, build
from alloc.allocation import FloatArray
from alloc.vehicle.geometry import DOF
from bench.demands.mission import RATE_HZ, move
from bench.demands.strong import axis_maxima, strong_demands, strong_vehicle
from bench.judging.judge import rounded
from bench.judging.loss import relative_wrench_error
from bench.record import SERVED_WITHIN, MixerCost, Move

EXACT = "scaled"
"""Method that is exact where the demand can be met and always answers."""
COSTLIEST = 3
"""Demands that are shown."""
MOVE_M, MOVE_S = 3.0, 5.0
"""Length [m] and time [s] of a move: the vehicle takes about four seconds."""


def mixer_cost(vehicle: Vehicle, taus: FloatArray) -> MixerCost | None:
    """The cost on demands (N, k) that can be met; None for a vehicle without an autopilot."""
    if vehicle.autopilot is None:
        return None
    try:
        allocators = build(vehicle.autopilot.method, vehicle), build(EXACT, vehicle)
        F, exact = (allocate.many(taus)[0] for allocate in allocators)
    except AllocError:  # too many facets, or all that is left is weak
        return None
    asked = strong_vehicle(vehicle), strong_demands(vehicle, taus)
    missed, exactly = (np.nan_to_num(relative_wrench_error(*asked, each), nan=1.0) for each in (F, exact))
    worst = np.argsort(-missed, kind="stable")[:COSTLIEST]
    return MixerCost(
        method=vehicle.autopilot.method,
        frame=vehicle.autopilot.frame,
        exact=EXACT,
        n_demands=len(taus),
        served=int(np.count_nonzero(missed <= SERVED_WITHIN)),
        exact_served=int(np.count_nonzero(exactly <= SERVED_WITHIN)),
        missed_p50=rounded(np.median(missed)),
        demands=_rounded(taus[worst]),
        wrenches=_rounded(F[worst] @ vehicle.TP.T),
        missed=[rounded(share) for share in missed[worst].tolist()],
        moves=list(simulate_moves(vehicle, *allocators)),
        move_m=MOVE_M,
        own_inertia=vehicle.inertia is not None,
    )


def simulate_moves(vehicle: Vehicle, mixer: Allocator, exact: Allocator) -> Iterator[Move]:
    """Moves along each axis of translation that the vehicle reaches both ways (``bench.demands.mission``)."""
    for axis, *ends in zip(vehicle.dof, *axis_maxima(vehicle), strict=True):
        if axis in DOF[:3] and all(ends):
            off_m, turned_deg = zip(_strays(vehicle, mixer, axis), _strays(vehicle, exact, axis), strict=True)
            yield Move(axis=axis, off_m=off_m, turned_deg=turned_deg)


def _strays(vehicle: Vehicle, allocate: Allocator, axis: str) -> tuple[float, float]:
    """Largest distance from the line [m] and turn, up to 180 [deg], of moves both ways along an axis."""
    other = [place for place in range(3) if DOF[place] != axis]
    off, turned = 0.0, 0.0
    for metres in (MOVE_M, -MOVE_M):
        poses = move(
            vehicle, axis, metres, round(MOVE_S * RATE_HZ), lambda tau: vehicle.TP @ allocate(tau).f
        ).poses
        off = max(off, float(np.linalg.norm(poses[:, other], axis=1).max()))
        turned = max(turned, float(np.degrees(np.abs(poses[:, 3:])).max()))
    return round(off, 3), min(180.0, round(turned, 1))


def _rounded(wrenches: FloatArray) -> list[list[float]]:
    return [[rounded(value) for value in row] for row in wrenches.tolist()]
