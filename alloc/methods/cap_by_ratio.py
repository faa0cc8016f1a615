"""Least effort without a cap, then all thrusts brought towards rest by one ratio until the current fits."""

import numpy as np

from alloc.allocation import Allocation, FloatArray, Status
from alloc.formulations.cap_rule import FORMULATION as ANSWERED
from alloc.nullspace.cap_rule import CapRuled, Scaled
from alloc.nullspace.current_cap import SPARE, reaches
from alloc.reach.edge import start
from alloc.vehicle import Vehicle
from alloc.vehicle.current import Draw
from alloc.vehicle.limits import Interval

FORMULATION = ANSWERED.name
NAMED_ONLY = True  # without a cap it is scaled


def build(vehicle: Vehicle) -> CapRuled:
    """Prepare f = rest + r (f_scaled - rest), r the largest ratio in [0, 1] whose currents fit the cap.

    A firmware that scales all pulses does so; thrusts are scaled here, which keeps the wrench's direction.
    """
    return CapRuled(vehicle, _by_ratio)


def _by_ratio(scaled: Scaled, tau: FloatArray, limits: Interval, draw: Draw, cap: float) -> Allocation:
    found = scaled(tau, *limits)
    if not found.found or draw.amps(found.f).sum() <= cap:
        return found
    rest = start(*limits)
    ratio = reaches(draw, cap * (1 - SPARE / 2), rest, found.f)
    return found._replace(
        f=rest + ratio * (found.f - rest),
        status=Status.PARTIAL,
        share=(ratio * found.share[0],),
        residual=ratio * np.asarray(found.residual),
    )
