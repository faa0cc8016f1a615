"""The cost of the exact answer in C and from Python, beside the fastest solvers for this size.

``python docs/studies/native_speed.py [VEHICLE …]`` prints the tables of results/studies/native_speed.md, from
which docs/exact.md quotes. ``--daqp CSRC`` adds DAQP's C from that folder of
its source distribution (``pip download --no-deps --no-binary daqp daqp``). Ratios are within one run;
demands are inactive, active and infeasible ones in equal parts, shuffled. Each figure is CPU time, the least
of several batches, because the least repeats on a machine that does other things as well. The study takes
about a minute of a quiet core.
"""

import argparse
import random
from collections.abc import Callable, Sequence
from functools import partial
from operator import matmul
from pathlib import Path
from time import thread_time

import numpy as np

from alloc import NotApplicable, Vehicle, build, catalogue, load_vehicle
from alloc.allocation import FloatArray
from bench.chips.kernels import Kernel, build_kernel
from bench.demands import build_demands
from bench.harness.timing import no_garbage_collection, sample
from by_hand import plain_product
from c_loop import instructions, nanoseconds
from daqp_c import daqp_kernel
from speed_tables import (
    DAQP,
    DAQP_C,
    EXACT,
    OSQP,
    PINV,
    PLAIN,
    PRODUCT,
    WALSH,
    Measured,
    tables,
)

VEHICLES = ("ukwial", "bluerov2", "bluerov2-heavy", "nautilus", "subjugator8", "supply-vessel")
CLASSES = ("inactive", "active", "infeasible")
PER_CLASS = 100
BUDGET_NS = 4_000_000
"""Time for two batches of 2 ms, for each callable and round."""
MANY = 200_000
"""Demands of a ``many()``."""
QUICK_SOLVERS = ("qp/daqp", "qp/piqp", "qp/proxqp", "qp/quadprog", "qp/osqp")
"""The live solvers that were the fastest on some vehicle; the others are tens of times slower."""


def demands(vehicle: Vehicle, classes: Sequence[str] = CLASSES) -> FloatArray:
    """The classes' demands in equal parts, shuffled."""
    taus = np.vstack([build_demands(name, vehicle, 0, PER_CLASS).taus for name in classes])
    return np.random.default_rng(0).permutation(taus)


def kernels(vehicle: Vehicle, csrc: Path | None) -> dict[str, Kernel]:
    """All kernels in C for a vehicle, by the name of their column."""
    by_column = {PLAIN: plain_product(vehicle)}
    if csrc:
        by_column[DAQP_C] = daqp_kernel(vehicle, csrc)
    for name in (PINV, WALSH, EXACT, OSQP):
        try:
            by_column[name] = build_kernel(name, vehicle, "double")
        except NotApplicable:
            continue
    return by_column


def daqp_ns(vehicle: Vehicle, taus: FloatArray, rounds: int) -> float:
    """Mean over demands of DAQP's own clock around its solve [ns], each the least of several passes."""
    allocate = build(DAQP, vehicle, start="reused")
    return float(
        np.min([[allocate(tau).solver_s for tau in taus] for _ in range(rounds)], axis=0).mean() * 1e9
    )


def interleaved(
    calls: dict[str, Callable[[FloatArray], object]], taus: FloatArray, rounds: int
) -> dict[str, float]:
    """CPU time of a call [ns], the least of all batches; the callables take turns in a seeded order."""
    inputs, order = [list(taus)], random.Random(0)
    batches: dict[str, list[float]] = {name: [] for name in calls}
    with no_garbage_collection():
        for _ in range(rounds):
            for name in order.sample(sorted(calls), len(calls)):
                measured = sample(calls[name], inputs, BUDGET_NS, singles=0)
                batches[name] += [batch.cpu_ns / batch.calls for batch in measured.batches]
    return {name: min(times) for name, times in batches.items()}


def measure(name: str, csrc: Path | None, rounds: int) -> Measured:
    """All figures of one vehicle."""
    vehicle = load_vehicle(name)
    taus, by_column = demands(vehicle), kernels(vehicle, csrc)
    c = {label: float(nanoseconds(kernel, taus, rounds).min()) for label, kernel in by_column.items()}
    by_class = {}
    for kind in CLASSES:
        of_kind = demands(vehicle, [kind])
        by_class[kind] = {
            label: float(nanoseconds(kernel, of_kind, rounds).min())
            for label, kernel in by_column.items()
            if label in (EXACT, DAQP_C, OSQP)
        } | {DAQP: daqp_ns(vehicle, of_kind, rounds)}
    solvers = solver_calls(vehicle)
    return Measured(
        vehicle=vehicle,
        c=c | {DAQP: daqp_ns(vehicle, taus, rounds)},
        by_class=by_class,
        counts={label: instructions(by_column[label], taus) for label in (PINV, EXACT)},
        calls=interleaved(python_calls(vehicle) | solvers, taus, rounds),
        solvers=tuple(solvers),
        per_second=many_per_second(vehicle, taus, rounds),
    )


def python_calls(vehicle: Vehicle) -> dict[str, Callable[[FloatArray], object]]:
    """The product that all calls are compared with, and this project's methods."""
    G = np.ascontiguousarray(build("pinv", vehicle).many(np.eye(vehicle.k))[0].T)
    calls: dict[str, Callable[[FloatArray], object]] = {PRODUCT: partial(matmul, G)}
    for label in ("nullspace", PINV, EXACT):
        calls[label] = build(label, vehicle)
    return calls


def solver_calls(vehicle: Vehicle) -> dict[str, Callable[[FloatArray], object]]:
    """The fastest live solvers that are installed, reused and warm."""
    calls: dict[str, Callable[[FloatArray], object]] = {}
    for entry in catalogue():
        if entry.name in QUICK_SOLVERS and not entry.missing:
            for start in {"reused", "warm"} & set(entry.starts):
                calls[f"{entry.name} {start}"] = build(entry.name, vehicle, start=start)
    return calls


def many_per_second(vehicle: Vehicle, taus: FloatArray, rounds: int) -> float:
    """Allocations per second of ``many()`` on one core, in the fastest of several calls."""
    allocate = build(EXACT, vehicle)
    many_taus = np.tile(taus, (MANY // len(taus) + 1, 1))
    times = []
    for _ in range(rounds):
        start = thread_time()
        allocate.many(many_taus)
        times.append(thread_time() - start)
    return len(many_taus) / min(times)


def main() -> None:
    """Measure and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("vehicles", nargs="*", default=VEHICLES)
    parser.add_argument("--daqp", type=Path, metavar="CSRC", help="that folder of DAQP's sdist")
    parser.add_argument(
        "--rounds", type=int, default=15, help="batches of each call, of which the least counts"
    )
    arguments = parser.parse_args()
    print(tables([measure(name, arguments.daqp, arguments.rounds) for name in arguments.vehicles]))


if __name__ == "__main__":
    main()
