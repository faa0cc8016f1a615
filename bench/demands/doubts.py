"""Doubts about a log: units that do not suit the vehicle, and limits that cross."""

from collections.abc import Set

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from bench.inputs.units import TIME

FACTOR = 300.0
"""How many times too much, or too little, a log asks of a vehicle before its units are in doubt. A demand is
seldom ten times what a vehicle can do, and a wrong prefix is a thousand."""
SLOWEST_HZ, FASTEST_HZ = 0.5, 2e4
"""Rates between which an allocator may be called."""


def doubts(
    log: str,
    vehicle: str,
    alpha: FloatArray,
    rate_hz: float | None,
    *,
    shares: bool = False,
    with_unit: Set[str] = frozenset(),
) -> list[str]:
    """One line for each unit that can't be right, with the factor that would mend it.

    Parameters
    ----------
    log, vehicle : their names
    alpha : (N,) alpha* of each demand [-]
    rate_hz : sampling rate, None where the demands are no sequence in time
    shares : whether the log is known to have shares, which no unit of force mends
    with_unit : quantities whose unit the log or the user says, for which no other one is guessed
    """
    sizes = [] if shares else _of_size(log, vehicle, alpha, said=bool(with_unit - {TIME}))
    return [*sizes, *of_rate(log, rate_hz, said=TIME in with_unit)]


def _of_size(log: str, vehicle: str, alpha: FloatArray, *, said: bool) -> list[str]:
    alpha = alpha[np.isfinite(alpha) & (alpha > 0)]
    if not len(alpha):
        return []
    if (typical := float(np.median(alpha))) < 1 / FACTOR:
        doubt = f"{log}: asks {1 / typical:.3g} times what {vehicle} can do;"
        remedy = " if it is in mN, --scale 0.001, and"
        return [f"{doubt}{'' if said else remedy} if the vehicle's limits are in kN, multiply them by 1000"]
    if (least := float(alpha.min())) > FACTOR:
        doubt = f"{log}: never asks more than {1 / least:.2g} of what {vehicle} can do"
        return [
            f"{doubt}; check the units of its columns" if said else f"{doubt}; if it is in kN, --scale 1000"
        ]
    return []


def of_rate(log: str, rate: float | None, *, said: bool) -> list[str]:
    """A line where a rate [Hz] can't be a control loop's; none is guessed where a unit is ``said``."""
    if rate is None or SLOWEST_HZ <= rate <= FASTEST_HZ:
        return []
    for unit, factor in () if said else (("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        if 1.0 <= rate * factor <= FASTEST_HZ:
            return [
                f"{log}: {rate:.3g} Hz; were its times in {unit}, {rate * factor:.4g} Hz:"
                f" name the column 't [{unit}]', or --columns 't=NAME [{unit}]'"
            ]
    return [f"{log}: {rate:.3g} Hz is no rate of a control loop; check the times and their unit"]


def crossing(N: int, low: FloatArray | None, high: FloatArray | None) -> BoolArray:
    """(N,) whether some limits (N, n) of each demand cross; nowhere without limits."""
    if low is None or high is None:
        return np.zeros(N, dtype=bool)
    crosses: BoolArray = np.any(low > high, axis=1)
    return crosses


def of_limits(log: str, crosses: BoolArray) -> str:
    """A line where limits of demands cross; empty where none do."""
    if not crosses.any():
        return ""
    return (
        f"{log}: limits cross in {np.count_nonzero(crosses):,} of {len(crosses):,} demands, first in demand"
        f" {crosses.argmax()} (counted from 0); no thrust lies within them, so no method can keep them"
    )
