"""Sentences on all demands of a set, asked of 100,000 others of that set.

``python docs/studies/fresh_demands.py [VEHICLE …]`` draws them for each shipped vehicle, minutes each, and
prints each sentence that fails: methods by which *nothing is lost* of 2,000 drawn evenly; what pinv
misses *up to*, at the worst of the corners and of these; methods that *answer every demand*, also demands
beyond what the vehicle can do. It ends with 1 where one fails.
"""

import sys
from collections.abc import Iterator, Sequence

import numpy as np

from alloc import AllocError, Vehicle, build, catalogue, list_vehicles, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.formulations import Family
from bench.demands import build_demands
from bench.demands.strong import strong_vehicle, unasked_weak_axes
from bench.judging.capability import N_DEMANDS, even_demands, limit_wrenches
from bench.judging.loss import gets_nothing
from bench.judging.worst import worst_loss
from bench.results.text import percent, three

FRESH = 100_000
LEFT_OUT = {"ardusub", "cap-by-ratio", "cap-by-thruster", "desaturate", "fixed-point", "frugal", "px4"}
"""Methods that take so many demands one by one in Python, hours of them."""
METHODS = [
    entry.name
    for entry in catalogue()
    if not entry.foreign and not entry.missing and entry.family != Family.SOFT and entry.name not in LEFT_OUT
]


def failed_sentences(vehicle: Vehicle) -> Iterator[str]:
    """Sentences of a run that other demands of the same set contradict."""
    asked, fresh = even_demands(vehicle, 0, N_DEMANDS), even_demands(vehicle, 1, FRESH)
    corners = unasked_weak_axes(vehicle, limit_wrenches(strong_vehicle(vehicle)))
    beyond = [build_demands("infeasible", vehicle, seed, n).taus for seed, n in ((0, 50), (1, FRESH))]
    for method in METHODS:
        try:
            allocate = build(method, vehicle)
        except AllocError:
            continue
        said, then = (worst_loss(vehicle, taus, allocate.many(taus)[0]) for taus in (asked, fresh))
        if said.missed_max <= WRENCH_TOLERANCE < then.missed_max:
            yield f"{method} lost nothing of {len(asked):,}, of others {percent(then.missed_max)}"
        if method == "pinv":
            ends = [said]
            if len(corners):
                ends.append(worst_loss(vehicle, corners, allocate.many(corners)[0]))
            most = max(each.missed_max for each in ends)
            turned = max(each.turned_max_deg or 0.0 for each in ends)
            where = f"up to {{}} of {len(asked):,} {'and corners' if len(corners) else 'alone'}, others {{}}"
            if then.missed_max > most:
                yield f"{method} missed {where.format(percent(most), percent(then.missed_max))}"
            if (then.turned_max_deg or 0.0) > turned:
                yield f"{method} turned {where.format(three(turned), three(then.turned_max_deg))} [°]"
        for few, many in ((asked, fresh), beyond):
            shares = [
                float(np.mean(_unanswered(vehicle, taus, allocate.many(taus)[0]))) for taus in (few, many)
            ]
            if shares[0] == 0.0 < shares[1]:
                refused = percent(shares[1])
                yield f"{method} answered each of {len(few):,}, of {len(many):,} others not {refused}"


def _unanswered(vehicle: Vehicle, taus: FloatArray, F: FloatArray) -> BoolArray:
    """Mask of demands (N,) without thrusts, or with a wrench of nothing."""
    mask: BoolArray = ~np.isfinite(F).all(axis=1) | gets_nothing(vehicle, taus, F)
    return mask


def main(names: Sequence[str]) -> int:
    """Print what fails; 1 where something does."""
    failures = 0
    for name in names:
        found = list(failed_sentences(load_vehicle(name)))
        failures += len(found)
        print("\n".join([f"{name}: {len(found)} fail", *(f"- {text}" for text in found)]), flush=True)
    return min(failures, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or list_vehicles()))
