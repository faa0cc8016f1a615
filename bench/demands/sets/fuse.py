"""Demands drawn to the cap of the vehicle's file: from half of what it allows to twice as much."""

import numpy as np

from alloc import AllocError, NotApplicable, Vehicle, alpha_max
from bench.demands import CallDemands, Supply
from bench.demands.strong import strong_vehicle

COUNT = 200
FARTHEST = 2.0
"""Largest demand, over what the cap allows along it, and one over the smallest [-]."""


def supply(vehicle: Vehicle) -> Supply:
    """The file's cap and its voltage; raises NotApplicable for a vehicle without a cap or currents."""
    if vehicle.cap is None:
        raise NotApplicable(f"{vehicle.name}: has no cap; add 'cap' to its file")
    try:
        vehicle.draw(vehicle.cap.volts)
        return Supply(vehicle.cap.amps(), vehicle.cap.volts)
    except AllocError as error:
        raise NotApplicable(str(error)) from None


def limited_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> CallDemands:
    """n demands of random thrusts, the logarithm of their size uniform, within the curves' ends.

    Raises NotApplicable where the cap leaves nothing, as for thrusters that can't stand still.
    """
    cap, volts = supply(vehicle)
    limits, strong = vehicle.esc_limits(volts), strong_vehicle(vehicle)
    taus = rng.uniform(*limits, (n, vehicle.n)) @ strong.TP.T
    reach = alpha_max(strong, taus, *limits, cap=cap, volts=volts)
    if not ((reach > 0.0) & np.isfinite(reach)).all():
        raise NotApplicable(f"{vehicle.name}: the cap leaves no thrust along some demands; raise it")
    size = reach * FARTHEST ** rng.uniform(-1.0, 1.0, n)
    low, high = (np.tile(side, (n, 1)) for side in limits)
    return CallDemands(size[:, None] * taus, low, high)
