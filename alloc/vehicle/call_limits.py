"""Limits that come with each call, checked."""

from collections.abc import Callable
from functools import lru_cache, partial
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alloc.allocation import (
    FLOAT64,
    LARGEST_DEMAND,
    WRENCH_TOLERANCE,
    Allocation,
    FloatArray,
    StatusArray,
    checked_many,
    real,
)
from alloc.errors import DemandError
from alloc.vehicle.azimuth import refuse_azimuths
from alloc.vehicle.condition import wrench_doubt
from alloc.vehicle.limits import Interval
from alloc.vehicle.model import Vehicle

AtCall = Callable[[ArrayLike | None, ArrayLike | None], Interval]
"""A function of f_min and f_max as a call gives them, None for the vehicle's: both checked, (n,) each [N]."""


@lru_cache(maxsize=256)
def widest(vehicle: Vehicle) -> float:
    """Largest thrust that a call may allow [N]: rounding takes a quarter of what SOLVED may miss of a wrench.

    Some 1e7 times the largest limit of a vehicle whose T is well conditioned, and never below that limit.
    """
    return vehicle.f_scale * max(1.0, WRENCH_TOLERANCE / 4 / wrench_doubt(vehicle))


def at_call(vehicle: Vehicle, *, held: bool = False) -> AtCall:
    """The function that checks the limits of one call for this vehicle; thrusters that are off stay off.

    f_min may exceed f_max, which leaves nothing to allocate. Limits are clipped to ±``widest``; a range
    wholly outside becomes empty, or stays with ``held``, for methods that answer within any limits.
    The function raises DemandError for another shape, and for entries
    that are no real numbers, NaN, or larger than LARGEST_DEMAND.
    """
    n, own_min, own_max, most = vehicle.n, vehicle.f_min, vehicle.f_max, widest(vehicle)
    off = vehicle.readiness == 0
    some_off = bool(off.any())

    shape = (n,)

    if vehicle.azimuths:
        return partial(_own, vehicle)

    def limits(f_min: ArrayLike | None, f_max: ArrayLike | None) -> Interval:
        low = own_min if f_min is None else f_min
        high = own_max if f_max is None else f_max
        # A control loop hands over plain arrays; one call of hypot finds NaN and large entries in them.
        if not (
            type(low) is np.ndarray
            and type(high) is np.ndarray
            and low.dtype is FLOAT64
            and high.dtype is FLOAT64
            and low.shape == high.shape == shape
            and hypot(*low.tolist(), *high.tolist()) <= most
        ):
            low, high = _cut(_side(low, "f_min", n, None), _side(high, "f_max", n, None), most, held)
        if some_off:
            return np.where(off, 0.0, low), np.where(off, 0.0, high)
        return low, high

    return limits


def _own(vehicle: Vehicle, f_min: ArrayLike | None, f_max: ArrayLike | None) -> Interval:
    """The box of a vehicle with azimuths; raises NotApplicable where a call has another."""
    given = ((f_min, vehicle.f_min), (f_max, vehicle.f_max))
    if any(side is not None and not _equal(np.asarray(side), own) for side, own in given):
        refuse_azimuths(vehicle.azimuths, "a call with f_min, f_max", "limits are polygons")
    return vehicle.f_min, vehicle.f_max


def _equal(given: NDArray[Any], own: FloatArray) -> bool:
    return given.shape[-1:] == own.shape and bool((given == own).all())


def _cut(low: FloatArray, high: FloatArray, most: float, held: bool) -> Interval:
    if held:
        return np.maximum(low, np.minimum(-most, high)), np.minimum(high, np.maximum(most, low))
    return np.maximum(low, -most), np.minimum(high, most)


def limits_of(
    vehicle: Vehicle, count: int, f_min: ArrayLike | None, f_max: ArrayLike | None, *, held: bool = False
) -> Interval:
    """f_min and f_max of each of ``count`` calls, (count, n) each [N]; what is left out is the vehicle's.

    Each is (n,) for all calls or (count, n); otherwise as ``at_call``.
    """
    if vehicle.azimuths:
        _own(vehicle, f_min, f_max)
    n = vehicle.n
    low = vehicle.f_min if f_min is None else _side(f_min, "f_min", n, count)
    high = vehicle.f_max if f_max is None else _side(f_max, "f_max", n, count)
    off, shape = vehicle.readiness == 0, (count, n)
    low, high = _cut(low, high, widest(vehicle), held)
    return np.broadcast_to(np.where(off, 0.0, low), shape), np.broadcast_to(np.where(off, 0.0, high), shape)


def one_by_one(
    allocate: Callable[..., Allocation],
    vehicle: Vehicle,
    taus: ArrayLike,
    f_min: ArrayLike | None = None,
    f_max: ArrayLike | None = None,
    **supply: float | None,
) -> tuple[FloatArray, StatusArray]:
    """``many`` by calling ``allocate`` on each row of ``taus`` (N, k) with that row's limits, in order.

    ``supply`` are the cap and the voltage of all calls, where the method takes them.
    """
    wrenches = checked_many(taus, vehicle.k)
    F = np.empty((len(wrenches), vehicle.n))
    status = np.empty(len(wrenches), dtype=np.int8)
    if f_min is None and f_max is None:
        for i, tau in enumerate(wrenches):
            F[i], status[i], *_ = allocate(tau, **supply)
        return F, status
    lows, highs = limits_of(vehicle, len(wrenches), f_min, f_max)
    for i, (tau, low, high) in enumerate(zip(wrenches, lows, highs, strict=True)):
        F[i], status[i], *_ = allocate(tau, low, high, **supply)
    return F, status


def _side(given: ArrayLike, key: str, n: int, count: int | None) -> FloatArray:
    """Limits of one side: (n,), or also (count, n) where there is a count; copied only where they must be."""
    try:
        limits = np.asarray(given)
        if limits.dtype is not FLOAT64:
            limits = real(limits)
    except (TypeError, ValueError, OverflowError) as error:
        raise DemandError(f"{key} is not an array of numbers ({error}); give n = {n} of them [N]") from None
    if limits.shape != (n,) and (count is None or limits.shape != (count, n)):
        several = "" if count is None else f", or ({count}, {n})"
        raise DemandError(f"{key} has shape {limits.shape}; this vehicle takes ({n},){several} [N]")
    if not (np.abs(limits) <= LARGEST_DEMAND).all():
        raise DemandError(
            f"{key} holds NaN, infinity or a number beyond {LARGEST_DEMAND:g}; give finite limits [N]"
        )
    return limits
