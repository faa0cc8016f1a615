"""Cost of a vehicle's own mixer: what it delivers of demands that its thrusters can meet."""

import numpy as np

from alloc import AllocError, Vehicle, build
from alloc.allocation import FloatArray
from bench.demands.strong import strong_demands, strong_vehicle
from bench.judging.judge import rounded
from bench.judging.loss import relative_wrench_error
from bench.record import SERVED_WITHIN, MixerCost

METHOD, EXACT = "ardusub", "scaled"
"""The mixer, and a method that is exact where the demand can be met and always answers."""
COSTLIEST = 3
"""Demands that are shown."""


def mixer_cost(vehicle: Vehicle, taus: FloatArray) -> MixerCost | None:
    """The cost on demands (N, k) that can be met; None for a vehicle without an autopilot."""
    if vehicle.autopilot is None:
        return None
    try:
        F, exact = (build(method, vehicle).many(taus)[0] for method in (METHOD, EXACT))
    except AllocError:  # too many facets, or all that is left is weak
        return None
    asked = strong_vehicle(vehicle), strong_demands(vehicle, taus)
    missed, exactly = (np.nan_to_num(relative_wrench_error(*asked, each), nan=1.0) for each in (F, exact))
    worst = np.argsort(-missed, kind="stable")[:COSTLIEST]
    return MixerCost(
        method=METHOD,
        frame=vehicle.autopilot.frame,
        exact=EXACT,
        n_demands=len(taus),
        served=int(np.count_nonzero(missed <= SERVED_WITHIN)),
        exact_served=int(np.count_nonzero(exactly <= SERVED_WITHIN)),
        missed_p50=rounded(float(np.median(missed))),
        demands=_rounded(taus[worst]),
        wrenches=_rounded(F[worst] @ vehicle.TP.T),
        missed=[rounded(share) for share in missed[worst].tolist()],
    )


def _rounded(wrenches: FloatArray) -> list[list[float]]:
    return [[rounded(value) for value in row] for row in wrenches.tolist()]
