"""qpbenchmark's harness and ours on the same problems: ``python -m bench.studies.cross_check``.

Its output is the table of docs/cross-check.md.
"""

from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import thread_time
from typing import NamedTuple

import numpy as np
from qpbenchmark.results import Results
from qpbenchmark.run import run

from alloc import Allocator, NotInstalled, Status, build
from bench.results.ranking import EXACT_WITHIN
from bench.results.text import table, three
from bench.studies.thrust_allocation import Case, ThrustAllocation

CALLS = 20
"""Calls a batch, on the CPU clock: on problems of microseconds one call measures the clock."""


class Ours(NamedTuple):
    """What our side says of one solver by one route: share solved and right, median time of a call."""

    right: float
    call_us: float


def theirs(problems: ThrustAllocation, settings: tuple[str, ...], solver: str | None = None) -> Results:
    """qpbenchmark's own results on the problems; ``solver`` leaves the others out."""
    with TemporaryDirectory() as folder:
        results = Results(Path(folder) / "results.csv", problems)
        for name in settings:
            run(problems, results, only_settings=name, only_solver=solver)
    return results


def ours(method: str, cases: list[Case]) -> Ours:
    """One method on the same problems, judged by its distance to the exact answer."""
    allocators: dict[str, tuple[Allocator, Allocator]] = {}
    right, times = 0, []
    for _, vehicle, tau in cases:
        if vehicle.name not in allocators:
            allocators[vehicle.name] = build(method, vehicle), build("nullspace", vehicle)
        allocate, exact = allocators[vehicle.name]
        allocate(tau)  # warm-up
        start = thread_time()
        for _ in range(CALLS):
            result = allocate(tau)
        times.append((thread_time() - start) / CALLS * 1e6)
        off = np.abs(result.f - exact(tau).f).max() / vehicle.f_scale
        right += result.status == Status.SOLVED and off <= EXACT_WITHIN
    return Ours(right / len(cases), median(times))


def lines(problems: ThrustAllocation) -> list[list[str]]:
    """One row a solver: success by qpbenchmark's settings, answers right by ours, three times."""
    frame = theirs(problems, ("default", "high_accuracy")).df
    found = []
    for solver in sorted(problems.solvers):
        mine = frame[frame["solver"] == solver]
        solved = []
        for settings in ("default", "high_accuracy"):
            limit = problems.tolerances[settings]
            part = mine[mine["settings"] == settings]
            worst = part[["primal_residual", "dual_residual", "duality_gap"]].astype(float).fillna(np.inf)
            solved.append(100 * float((part["found"] & (worst < limit.primal).all(axis=1)).mean()))
        try:
            one_shot, live = (ours(f"{route}/{solver}", problems.cases) for route in ("qpsolvers", "qp"))
        except (NotInstalled, LookupError):
            continue
        theirs_us = 1e6 * float(mine[mine["settings"] == "default"]["runtime"].median())
        right = (100 * one_shot.right, 100 * live.right)
        times_us = (theirs_us, one_shot.call_us, live.call_us)
        found.append([solver, *map(three, (*solved, *right, *times_us))])
    return found


HEADERS = [
    "solver",
    "qpbenchmark default [% solved]",
    "qpbenchmark high accuracy [% solved]",
    "qpsolvers/… right [%]",
    "qp/… right [%]",
    "qpbenchmark [µs]",
    "qpsolvers/… [µs]",
    "qp/… [µs]",
]

if __name__ == "__main__":
    problems = ThrustAllocation()
    print(f"{len(problems.cases)} problems")
    print(table(HEADERS, lines(problems)))
