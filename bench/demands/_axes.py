"""How far the vehicle reaches along each single axis."""

import numpy as np

from alloc import NotApplicable, Vehicle, alpha_max
from alloc.allocation import FloatArray


def single_axis_maxima(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    """Largest wrench (k,) backward (<= 0) and forward (>= 0) along each axis alone [N, N m].

    0 for an axis that can't be pushed alone, as after a failure that costs rank. Raises NotApplicable
    where zero wrench is not attainable, since no axis starts there.
    """
    axes = np.eye(vehicle.k)
    forward, backward = alpha_max(vehicle, axes), alpha_max(vehicle, -axes)
    if np.isneginf(forward).any() or np.isneginf(backward).any():
        raise NotApplicable(
            f"{vehicle.name}: the limits do not let the wrench be zero, so no axis can be alone"
        )
    return -backward, forward
