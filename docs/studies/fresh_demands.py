"""Sentences on all demands of a set, asked of 100,000 others of that set.

``python docs/studies/fresh_demands.py [VEHICLE …]`` draws them for each shipped vehicle, minutes each, and
prints each sentence that fails. Methods by which *nothing is lost* of 2,000 drawn evenly may lose part of
less than 0.5 % of all, as the report says; so many may be worse than the *worst* of pinv, at corners and
these. What *answers every demand* must answer all others, too, also of those that can't be met. It ends with
1 where a sentence fails.
"""

import sys
from collections.abc import Iterator, Sequence

import numpy as np

from alloc import Allocator, AllocError, Vehicle, build, catalogue, list_vehicles, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.formulations import Family
from bench.demands import build_demands
from bench.demands.strong import strong_demands, strong_vehicle, unasked_weak_axes
from bench.judging.capability import N_DEMANDS, even_demands, limit_wrenches
from bench.judging.loss import direction_error_deg, gets_nothing
from bench.judging.worst import strong_error
from bench.results.text import RARE, percent

FRESH = 100_000
LEFT_OUT = {"ardusub", "cap-by-ratio", "cap-by-thruster", "desaturate", "fixed-point", "frugal", "px4"}
"""Methods that take so many demands one by one in Python, hours of them."""
METHODS = [
    entry.name
    for entry in catalogue()
    if not entry.foreign and not entry.missing and entry.family != Family.SOFT and entry.name not in LEFT_OUT
]


def failed_sentences(vehicle: Vehicle, methods: Sequence[str] = METHODS) -> Iterator[str]:
    """Sentences of a run that other demands of the same set contradict."""
    asked, fresh = even_demands(vehicle, 0), even_demands(vehicle, 1, FRESH)
    corners = unasked_weak_axes(vehicle, limit_wrenches(strong_vehicle(vehicle)))
    beyond = [build_demands("infeasible", vehicle, seed, n).taus for seed, n in ((0, 50), (1, FRESH))]
    for method in methods:
        try:
            allocate = build(method, vehicle)
        except AllocError:
            continue
        missed, others = (losses(vehicle, allocate, taus)[0] for taus in (asked, fresh))
        if missed.max() <= WRENCH_TOLERANCE:
            yield from exceeded(f"{method} lost nothing", WRENCH_TOLERANCE, others, "missed {:.3g}")
        if method == "pinv":
            ends = losses(vehicle, allocate, np.concatenate([asked, corners]))
            for what, said, then in zip(
                ("missed {:.3g}", "turned {:.3g}°"), ends, losses(vehicle, allocate, fresh), strict=True
            ):
                yield from exceeded(f"{method} {what.format(said.max())} at worst", said.max(), then, what)
        for few, many in ((asked, fresh), beyond):
            answers = (allocate.many(taus)[0] for taus in (few, many))
            shares = [
                np.mean(unanswered(vehicle, taus, F)) for taus, F in zip((few, many), answers, strict=True)
            ]
            if shares[0] == 0.0 < shares[1]:
                refused = percent(float(shares[1]))
                yield f"{method} answered each of {len(few):,}, of {len(many):,} others not {refused}"


def exceeded(sentence: str, worst: float, others: FloatArray, found: str) -> Iterator[str]:
    """The sentence, where more of other demands (N,) are worse than a run's report permits."""
    share = float(np.mean(others > worst))
    if share >= RARE / N_DEMANDS:
        yield f"{sentence}, but {percent(share)} of {len(others):,} others: {found.format(others.max())}"


def losses(vehicle: Vehicle, allocate: Allocator, taus: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shares of demands not delivered (N,), 1 without thrusts, and turns of the wrench (N,) [deg]."""
    F = allocate.many(taus)[0]
    turned = direction_error_deg(strong_vehicle(vehicle), strong_demands(vehicle, taus), F)
    return np.nan_to_num(strong_error(vehicle, taus, F), nan=1.0), np.nan_to_num(turned)


def unanswered(vehicle: Vehicle, taus: FloatArray, F: FloatArray) -> BoolArray:
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
