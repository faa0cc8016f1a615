"""Worst of a method over a set of demands, and what is to be expected of others drawn like them."""

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from bench.demands.strong import strong_demands, strong_vehicle
from bench.judging.judge import rounded
from bench.judging.loss import direction_error_deg, relative_wrench_error
from bench.record import MISSED_MUCH, Loss


def strong_error(vehicle: Vehicle, taus: FloatArray, F: FloatArray) -> FloatArray:
    """``relative_wrench_error`` (N,) of what demands ask of the strong part."""
    return relative_wrench_error(strong_vehicle(vehicle), strong_demands(vehicle, taus), F)


def worst_loss(vehicle: Vehicle, taus: FloatArray, F: FloatArray) -> Loss:
    """Worst of thrusts F (N, n) for demands (N, k) that can be met, and what it says of others."""
    missed: FloatArray = np.nan_to_num(strong_error(vehicle, taus, F), nan=1.0)
    turned = direction_error_deg(strong_vehicle(vehicle), strong_demands(vehicle, taus), F)
    known = turned[~np.isnan(turned)]
    return Loss(
        n_demands=len(taus),
        n_answers=int(np.isfinite(F).all(axis=1).sum()),
        missed_max=rounded(missed.max()),
        turned_max_deg=rounded(known.max()) if known.size else None,
        missed_much=int(np.count_nonzero(missed >= MISSED_MUCH)),
        nothing_expected=rounded(expected_count(missed, 1.0)),
    )


TAIL = 10
"""Largest values by which a tail is known."""


def expected_count(values: FloatArray, edge: float) -> float:
    """Number beyond an edge that is expected of as many other values drawn like these (N,).

    Where fewer than TAIL of these are, by an exponential tail through the largest: TAIL exp(-(edge - v) / s),
    v the largest but TAIL, s the mean by which those above are larger.
    """
    beyond = int(np.count_nonzero(values >= edge))
    if beyond >= TAIL or len(values) <= TAIL:
        return float(beyond)
    *above, v = np.sort(values)[: -TAIL - 2 : -1]
    s = float(np.mean(above) - v)
    return float(TAIL * np.exp(-(edge - v) / s)) if s > 0 else 0.0
