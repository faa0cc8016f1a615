"""What scaled and priority answer beyond the limits: the numbers of docs/saturation.md.

``python docs/studies/saturation.py programs [CASES [METHOD …]]`` works each share out again by a linear
program (HiGHS), and the thrusts by DAQP at the wrench that the programs reach. With ``limits [CALLS
[METHOD …]]`` it counts answers that are not finite, or lie beyond a limit by as little as the last digit.
Methods are those in Python unless others are named, as ``scaled@native``.
"""

import sys
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np

from alloc import Allocator, Status, Vehicle, build, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.formulations import find_formulation
from alloc.reach.attainable import alpha_max_lp
from alloc.reach.edge import start
from alloc.reach.way import Way, step_maps
from bench.results.text import table, three

METHODS = ("scaled", "scaled-by-group", "priority")
CASES, CALLS, CHUNK = 7_000, 10_000_000, 20_000
SMALL = 1e-2
"""Steps below this share of wrench_scale are left out: HiGHS knows the wrench to 1e-10 only."""


@cache
def vehicles() -> tuple[Vehicle, ...]:
    """Each shipped vehicle whole, with each thruster off, and with two off, which costs some of them rank."""
    whole = [load_vehicle(name) for name in list_vehicles()]
    single = [v.with_fault(i) for v in whole for i in range(v.n)]
    return (*whole, *single, *(v.with_fault(0).with_fault(1) for v in whole))


def limits(vehicle: Vehicle, rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray]:
    """Limits (n, thrusters) [N]: the vehicle's own, and others that may exclude zero or have no width."""
    low = rng.uniform(-1.0, 0.6, (n, vehicle.n)) * vehicle.f_scale
    width = rng.uniform(0.0, 1.2, (n, vehicle.n)) * (rng.random((n, vehicle.n)) > 0.05) * vehicle.f_scale
    own = rng.random((n, 1)) < 0.2
    low, high = np.where(own, vehicle.f_min, low), np.where(own, vehicle.f_max, low + width)
    return np.where(vehicle.readiness == 0, 0.0, low), np.where(vehicle.readiness == 0, 0.0, high)


def share_by_program(
    vehicle: Vehicle, w: FloatArray, step: FloatArray, low: FloatArray, high: FloatArray, keep: float
) -> float:
    """min(1, keep beta) of a step from a wrench w, by a linear program that knows nothing of facets."""
    return max(0.0, min(1.0, keep * alpha_max_lp(vehicle, step, low, high, start=w)))


def way_of(allocate: Allocator, vehicle: Vehicle) -> Way:
    """The way that an allocator goes on its vehicle."""
    way = find_formulation(allocate.formulation).way
    assert way is not None
    return way(vehicle)


class Programs(NamedTuple):
    """Distances of a method's answers from those of programs.

    Attributes
    ----------
    cases : demands, each with limits of its own
    excluding : cases whose limits exclude zero thrust
    shares : shares compared
    share_off : farthest share [-]
    thrust_off : farthest thrust, relative to the largest limit [-]
    unsolved : cases for which DAQP had no answer; their thrusts are not compared
    """

    cases: int
    excluding: int
    shares: int
    share_off: float
    thrust_off: float
    unsolved: int


def against_programs(method: str, cases: int) -> Programs:
    """Compare a method with programs, on at least so many cases."""
    rng = np.random.default_rng(2004)
    share_off, thrust_off, unsolved, excluding = [], [], 0, 0
    each = -(-cases // len(vehicles()))
    for vehicle in vehicles():
        allocate, reference = build(method, vehicle), build("qp/daqp", vehicle)
        way = way_of(allocate, vehicle)
        maps = step_maps(vehicle, way.levels)
        lows, highs = limits(vehicle, rng, each)
        taus = rng.normal(size=(each, vehicle.k)) * vehicle.wrench_scale * 10 ** rng.uniform(-1, 1, (each, 1))
        for tau, low, high in zip(taus, lows, highs, strict=True):
            f, _, _, _, share, *_ = allocate(tau, low, high)
            w = vehicle.TP @ start(low, high)
            for D, keep, taken in zip(maps, way.keep, share, strict=True):
                step = D @ (tau - w)
                expected = share_by_program(vehicle, w, step, low, high, keep)
                if np.abs(step / vehicle.wrench_scale).max() > SMALL:
                    share_off.append(abs(taken - expected))
                w = w + expected * step
            right = reference(w, low, high)
            unsolved += right.status != Status.SOLVED
            if right.status == Status.SOLVED:
                thrust_off.append(float(np.abs(f - right.f).max() / vehicle.f_scale))
            excluding += bool(((low > 0) | (high < 0)).any())
    total = each * len(vehicles())
    return Programs(total, excluding, len(share_off), max(share_off), max(thrust_off), unsolved)


def hard(vehicle: Vehicle, rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Demands (n, k) and limits (n, thrusters) of all sizes, from subnormal numbers to 1e100, also mixed."""
    low, high = limits(vehicle, rng, n)
    wide = rng.random(n) < 0.3
    ends = 10.0 ** rng.uniform(-320, 100, (n, 2, 1)) * rng.normal(size=(n, 2, vehicle.n)).clip(-1, 1)
    low[wide], high[wide] = ends[wide].min(axis=1), ends[wide].max(axis=1)
    thin = rng.random((n, vehicle.n)) < 0.1
    high = np.where(thin, np.nextafter(low, np.inf), np.maximum(low, high))
    corner = np.where(rng.random((n, vehicle.n)) < 0.5, low, high)
    taus = rng.normal(size=(n, vehicle.k)) * vehicle.wrench_scale * 10 ** rng.uniform(-6, 6, (n, 1))
    kind = rng.integers(4, size=n)
    taus = np.where((kind == 1)[:, None], corner @ vehicle.TP.T, taus)  # on the edge, or inside
    alone = rng.integers(vehicle.k, size=n)
    taus[kind == 2] *= np.eye(vehicle.k)[alone[kind == 2]]
    taus[kind == 3] = rng.normal(size=(np.count_nonzero(kind == 3), vehicle.k)).clip(
        -1, 1
    ) * 10.0 ** rng.uniform(-320, 100, (np.count_nonzero(kind == 3), 1))
    return taus.clip(-1e100, 1e100), low, high


def batches(calls: int) -> Iterator[tuple[int, Vehicle]]:
    """Numbers of calls and their vehicles, in turn, until there are as many as asked."""
    for i in range(-(-calls // CHUNK)):
        yield min(CHUNK, calls - i * CHUNK), vehicles()[i % len(vehicles())]


class WithinLimits(NamedTuple):
    """Answers of a method to hard demands within hard limits.

    Attributes
    ----------
    calls : demands, each with limits of its own
    good : answers that are finite and inside their limits, to the last digit
    solved : answers that are SOLVED
    lies : answers that are SOLVED although they miss the wrench
    """

    calls: int
    good: int
    solved: int
    lies: int


def within_limits(method: str, calls: int) -> WithinLimits:
    """Count so many answers of a method, through ``many``."""
    rng = np.random.default_rng(2026)
    good = solved = lies = 0
    for n, vehicle in batches(calls):
        taus, low, high = hard(vehicle, rng, n)
        F, status = build(method, vehicle).many(taus, low, high)
        off = vehicle.readiness == 0
        inside = (np.where(off, 0.0, low) <= F) & (np.where(off, 0.0, high) >= F)  # NaN fails both
        good += int(np.count_nonzero(inside.all(axis=1)))
        solved += int(np.count_nonzero(status == Status.SOLVED))
        size = np.maximum(1.0, np.abs(F).max(axis=1) / vehicle.f_scale)  # 1e100 N are known to 1e84 N
        missed = np.abs((F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max(axis=1)
        lies += int(np.count_nonzero((status == Status.SOLVED) & ~(missed <= 1e-6 * size)))
    return WithinLimits(calls, good, solved, lies)


def main(what: str = "limits", count: str = "", *methods: str) -> None:
    """Print the table of one of the two parts."""
    chosen = methods or METHODS
    if what == "programs":
        headers = [
            "cases",
            "limits exclude zero",
            "shares",
            "farthest share",
            "farthest thrust",
            "DAQP gave none",
        ]
        found: list[NamedTuple] = [against_programs(method, int(count or CASES)) for method in chosen]
    else:
        headers = ["calls", "finite and inside the limits", "SOLVED", "SOLVED, but the wrench is missed"]
        found = [within_limits(method, int(count or CALLS)) for method in chosen]
    cells = [[f"{x:,}" if isinstance(x, int) else three(x) for x in row] for row in found]
    print(table(["method", *headers], [[method, *row] for method, row in zip(chosen, cells, strict=True)]))


if __name__ == "__main__":
    main(*sys.argv[1:])
