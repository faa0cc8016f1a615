"""Limits that come with each call, checked."""

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray, real
from alloc.errors import DemandError
from alloc.vehicle.limits import Interval
from alloc.vehicle.model import Vehicle


def limits_of(vehicle: Vehicle, count: int, f_min: ArrayLike | None, f_max: ArrayLike | None) -> Interval:
    """f_min and f_max of each of ``count`` calls, (count, n) each [N]; what is left out is the vehicle's.

    Each is (n,) for all calls or (count, n); f_min may exceed f_max, which leaves nothing to allocate.
    Thrusters that are off stay off. Raises DemandError for another shape, and for what is no finite number.
    """
    low, high = (
        np.broadcast_to(_side(vehicle, count, key, own if given is None else given), (count, vehicle.n))
        for key, given, own in (("f_min", f_min, vehicle.f_min), ("f_max", f_max, vehicle.f_max))
    )
    off = vehicle.readiness == 0
    return np.where(off, 0.0, low), np.where(off, 0.0, high)


def _side(vehicle: Vehicle, count: int, key: str, given: ArrayLike) -> FloatArray:
    n = vehicle.n
    try:
        limits = real(np.asarray(given))
    except (TypeError, ValueError, OverflowError) as error:
        raise DemandError(f"{key} is not an array of numbers ({error}); give n = {n} of them [N]") from None
    if limits.shape not in ((n,), (count, n)):
        raise DemandError(f"{key} has shape {limits.shape}; this vehicle takes ({n},), or ({count}, {n}) [N]")
    if not np.isfinite(limits).all():
        raise DemandError(f"{key} holds NaN or infinity; give finite limits [N]")
    return limits
