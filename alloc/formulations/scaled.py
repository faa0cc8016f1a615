"""The least effort for the largest attainable share of the wrench, whose direction is kept.

The right answer is the hard optimum of min(1, alpha*) tau. Where no thruster pushes a part of tau, only the
other part, T P T* tau, is asked.
"""

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.formulations import EXACT_METHODS, Family, Formulation
from alloc.reach.attainable import alpha_max
from alloc.vehicle import Vehicle

INWARD = 1e-12
"""Share by which a demand is moved inside the attainable set, so that rounding leaves it there [-]."""


def attainable_share(
    vehicle: Vehicle, taus: FloatArray, f_min: FloatArray | None = None, f_max: FloatArray | None = None
) -> FloatArray:
    """min(1, alpha*) tau for demands (N, k) [N, N m]; zero where no share is attainable."""
    asked = taus
    if vehicle.rank < vehicle.k:
        asked = taus @ (vehicle.TP @ generalized_inverse(vehicle)).T
    alpha = alpha_max(vehicle, asked, f_min, f_max)
    reach = np.clip(np.where(np.isfinite(alpha), alpha, 1.0), 0.0, 1.0)
    shrunk: FloatArray = asked * np.where(reach < 1, reach * (1 - INWARD), 1.0)[:, None]
    return shrunk


FORMULATION = Formulation(
    name="scaled",
    title="the optimum, direction kept",
    meaning="keeps its direction",
    family=Family.EXACT,
    limited=True,
    optimal=True,
    references=EXACT_METHODS,
    reference_demands=attainable_share,
)
