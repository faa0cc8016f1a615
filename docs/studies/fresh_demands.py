"""Sentences on all demands of a set, asked of 100,000 others of that set.

``python docs/studies/fresh_demands.py [VEHICLE …]`` draws them for each shipped vehicle, minutes each, and
prints each sentence that fails. Methods by which *nothing is lost* of 2,000 drawn evenly may lose part of
less than 0.5 % of all, as the report says; so many may be worse than the *worst* of pinv, at corners and
these. What *answers every demand* must answer all others, too, also of those that can't be met. So many may
be worse than the worst after a failure, announced or not, than what an autopilot costs most, and than the
worst share and current below a cap, by how many each was asked. Below a cap, bounds take the place of linear
programs, which are solved only until fewer than so many can be worse. It ends with 1 where a sentence fails:
on the seven shipped vehicles none does.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from alloc import Allocator, AllocError, Vehicle, build, catalogue, list_vehicles, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.formulations import Family
from alloc.vehicle.current import Cap
from bench.demands import build_demands
from bench.demands.strong import strong_demands, strong_vehicle, unasked_weak_axes
from bench.judging.cap import DIRECTIONS, LARGEST, WAYS, compare_ways, stretch_demands
from bench.judging.capability import N_DEMANDS, even_demands, limit_wrenches
from bench.judging.loss import direction_error_deg, gets_nothing
from bench.judging.mixer import mixer_cost
from bench.judging.unannounced import (
    announced_costs,
    announced_thrusts,
    delivered_shares,
    failed_thrusts,
    failure_costs,
)
from bench.judging.worst import strong_error
from bench.record import SERVED_WITHIN, FailureCost
from bench.results.text import RARE, percent
from least_current import Capped

FRESH = 100_000
CAP = Cap(most=20.0, volts=12.0)
"""Cap of a vehicle that has none in its file, as in ``docs/studies/fuse.py``."""
ROUNDING = 1e-6
"""Difference of shares that decides nothing: a record has six digits."""
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
        yield from failed_failures(
            vehicle, method, *((taus, allocate.many(taus)[0]) for taus in (asked, fresh))
        )
    yield from failed_announced(vehicle, asked, fresh)
    yield from failed_mixer(vehicle, asked, fresh)
    yield from failed_fuse(vehicle)


Answered = tuple[FloatArray, FloatArray]
"""Demands (N, k) [N, N m] and thrusts (N, n) [N]."""


def failed_failures(vehicle: Vehicle, method: str, asked: Answered, fresh: Answered) -> Iterator[str]:
    """Least shares of a demand that a method delivers after failures nobody announces, contradicted."""
    taus, F = (part[np.isfinite(fresh[1]).all(axis=1)] for part in fresh)
    for cost in failure_costs(vehicle, method, *asked):
        yield from less(vehicle, cost, taus, lambda i, name: failed_thrusts(vehicle, F, i, name))


def failed_announced(vehicle: Vehicle, asked: FloatArray, fresh: FloatArray) -> Iterator[str]:
    """The same once failures are announced."""
    F = build("scaled", vehicle).many(fresh)[0]
    for cost in announced_costs(vehicle, asked):
        yield from less(vehicle, cost, fresh, lambda i, name: announced_thrusts(vehicle, fresh, F, i, name))


def less(
    vehicle: Vehicle, cost: FailureCost, taus: FloatArray, made: Callable[[int, str], FloatArray]
) -> Iterator[str]:
    """Least shares of a failure, where more of other demands (N, k) get less: of thrusts ``made`` (N, n)."""
    for i, least in zip(cost.thrusters, cost.share_min, strict=True):
        shares, _ = delivered_shares(vehicle, taus, made(i, cost.failure))
        what = f"{cost.method} with thruster {i} {cost.failure}{', announced,' * cost.announced}"
        worst = 1.0 - least
        yield from exceeded(
            f"{what} missed {worst:.3g} at worst", worst + ROUNDING, 1.0 - shares, "{:.3g}", cost.n_demands
        )


def failed_mixer(vehicle: Vehicle, asked: FloatArray, fresh: FloatArray) -> Iterator[str]:
    """Sentences on an autopilot and the exact answer beside it, contradicted; none without an autopilot."""
    if (cost := mixer_cost(vehicle, asked)) is None:
        return
    missed, exactly = (losses(vehicle, build(name, vehicle), fresh)[0] for name in (cost.method, cost.exact))
    worst = cost.missed[0]
    yield from exceeded(f"{cost.method} cost {worst:.3g}", worst + ROUNDING, missed, "missed {:.3g}")
    if cost.exact_served == cost.n_demands:
        yield from exceeded(f"{cost.exact} delivered all", SERVED_WITHIN, exactly, "missed {:.3g}")


def failed_fuse(vehicle: Vehicle) -> Iterator[str]:
    """Worst shares and currents of each way to keep a cap, contradicted; none without known currents.

    A vehicle without a cap in its file gets CAP. The largest share and the least current are left out: the
    others are compared with them.
    """
    if not vehicle.esc or vehicle.esc[0].current is None:
        return
    vehicle = replace(vehicle, cap=vehicle.cap or CAP)
    said, fresh = compare_ways(vehicle, even_demands(vehicle, 0, DIRECTIONS)), even_demands(vehicle, 1, FRESH)
    for way in said.keys() - {LARGEST}:
        bounds = way_bounds(vehicle, way, fresh)
        for j, (what, sign) in enumerate((("share", -1.0), ("current", 1.0))):
            worst, others = float(np.max(sign * said[way][j])) + ROUNDING, sign * bounds[j]
            for i in np.flatnonzero(others > worst):
                if np.mean(others > worst) < RARE / DIRECTIONS:
                    break
                others[i] = sign * compare_ways(vehicle, fresh[[i]])[way][j][0]
            yield from exceeded(f"{way}: worst {what} {abs(worst):.3g}", worst, others, "{:.3g}", DIRECTIONS)


def way_bounds(vehicle: Vehicle, way: str, taus: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds (N,) of what ``compare_ways`` finds of a way: shares are at least, currents at most so large."""
    assert vehicle.cap is not None
    amps, volts = vehicle.cap.amps(), vehicle.cap.volts
    limits, asked = vehicle.esc_limits(volts), stretch_demands(vehicle, taus)
    T, scaled = vehicle.strong.TP.T, build("scaled", vehicle)
    F, _ = build(WAYS[way], vehicle).many(asked, *limits, cap=amps, volts=volts)
    lean, _ = scaled.many(F @ T, *limits)
    shares, currents = Capped(vehicle, limits, vehicle.draw(volts), amps).bounds(F, lean)
    whole, _ = scaled.many(asked, *limits)
    within, most = (np.linalg.norm(f @ T / vehicle.wrench_scale, axis=1) for f in (F, whole))
    return np.maximum(shares, within / most), currents


def exceeded(
    sentence: str, worst: float, others: FloatArray, found: str, n: int = N_DEMANDS
) -> Iterator[str]:
    """The sentence on n demands, where more of other demands (N,) are worse than a run's report permits."""
    share = float(np.mean(others > worst))
    if share >= RARE / n:
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
