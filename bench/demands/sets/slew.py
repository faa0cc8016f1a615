"""The mission with thrusters that take time: each call's limits lie around the thrusts of the call before."""

import numpy as np

from alloc import NotApplicable, Vehicle, build
from bench.demands import CallDemands
from bench.demands.mission import HALF, RATE_HZ, under_way

__all__ = ["COUNT", "RATE_HZ", "SEED_NAME", "limited_demands"]

COUNT = HALF
SEED_NAME = "mission"


def limited_demands(vehicle: Vehicle, rng: np.random.Generator, n: int) -> CallDemands:
    """n consecutive demands of the mission, and what slew rates leave of the limits from one to the next.

    Thrusters are at rest at first. Then the thrusts of the call before are those of ``scaled``: the exact
    answer where there is one, else the largest share of the demand; where the vehicle has ESCs, what these
    made of it. So all methods are asked the same,
    whatever they answered before. Raises NotApplicable for a vehicle without slew rates.
    """
    if vehicle.slew is None:
        raise NotApplicable(f"{vehicle.name}: has no slew rates; add 'slew' [N/s] to its file")
    if any(esc.needs_volts for esc in vehicle.esc):
        raise NotApplicable(f"{vehicle.name}: its ESCs' curve has several voltages; add 'volts' to 'esc'")
    taus = under_way(vehicle, rng, n)
    allocate = build("scaled", vehicle)
    lows, highs, previous = np.empty((3, n, vehicle.n))
    f = np.clip(0.0, vehicle.f_min, vehicle.f_max)
    for i, tau in enumerate(taus):
        previous[i] = f
        lows[i], highs[i] = vehicle.limits(f_previous=f, dt=1 / RATE_HZ)
        f = allocate(tau, lows[i], highs[i]).f
        if vehicle.esc:
            f = vehicle.commands(f, f_min=lows[i], f_max=highs[i]).f
    return CallDemands(taus, lows, highs, previous)
