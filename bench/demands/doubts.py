"""Units of a log that can't be right, as the vehicle that should answer it tells."""

import numpy as np

from bench.demands import DemandSet

FACTOR = 300.0
"""How many times too much, or too little, a log asks of a vehicle before its units are in doubt. A demand is
seldom ten times what a vehicle can do, and a wrong prefix is a thousand."""
SLOWEST_HZ, FASTEST_HZ = 0.5, 2e4
"""Rates between which an allocator may be called."""


def doubts(demands: DemandSet) -> list[str]:
    """One line for each unit that can't be right, with the factor that would mend it."""
    return [*_of_size(demands), *_of_rate(demands)]


def _of_size(demands: DemandSet) -> list[str]:
    pushed = demands.taus[np.isfinite(demands.alpha) & (demands.alpha > 0)]
    alpha = demands.alpha[np.isfinite(demands.alpha) & (demands.alpha > 0)]
    if not len(pushed):
        return []
    if (typical := float(np.median(alpha))) < 1 / FACTOR:
        return [
            f"{demands.name}: asks {1 / typical:.3g} times what {demands.vehicle.name} can do; if it is"
            " in mN, --scale 0.001, and if the vehicle's limits are in kN, multiply them by 1000"
        ]
    if (least := float(alpha.min())) > FACTOR:
        return [
            f"{demands.name}: never asks more than {1 / least:.2g} of what {demands.vehicle.name} can do;"
            " if it is in kN, --scale 1000; if normalised, --scale with what 1 means on each axis [N, N m]"
        ]
    return []


def _of_rate(demands: DemandSet) -> list[str]:
    rate = demands.rate_hz
    if rate is None or SLOWEST_HZ <= rate <= FASTEST_HZ:
        return []
    for unit, factor in (("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        if 1.0 <= rate * factor <= FASTEST_HZ:
            return [
                f"{demands.name}: {rate:.3g} Hz; were its times in {unit}, {rate * factor:.4g} Hz:"
                f" name the column 't [{unit}]', or --columns 't=NAME [{unit}]'"
            ]
    return [f"{demands.name}: {rate:.3g} Hz is no rate of a control loop; check the unit of its times"]
