"""qpbenchmark's harness and this project's on the same problems: the table of docs/cross-check.md.

``python docs/studies/cross_check.py`` prints it.
"""

from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import thread_time
from typing import NamedTuple

import numpy as np
from qpbenchmark.results import Results
from qpbenchmark.run import run

from alloc import Allocator, Status, build
from alloc.errors import NotInstalled
from bench.results.ranking import EXACT_WITHIN
from bench.results.text import table, three
from thrust_allocation import AllocationCase, ThrustAllocation

CALLS = 20
"""Calls of a batch on the CPU clock: a single call of microseconds would measure the clock."""


class Ours(NamedTuple):
    """This project's measurement of one solver by one route.

    Attributes
    ----------
    right : share of problems that are solved and right [-]
    call_us : median time of a call [us]
    """

    right: float
    call_us: float


def theirs(problems: ThrustAllocation, settings: tuple[str, ...], solver: str | None = None) -> Results:
    """qpbenchmark's own results on the problems, of one ``solver`` or of all."""
    with TemporaryDirectory() as folder:
        results = Results(Path(folder) / "results.csv", problems)
        for name in settings:
            run(problems, results, only_settings=name, only_solver=solver)
    return results


def ours(method: str, cases: list[AllocationCase]) -> Ours:
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
    """One row for each solver: success by qpbenchmark's settings, right answers by ours, and three times."""
    frame = theirs(problems, ("default", "high_accuracy")).df
    rows = []
    for solver in sorted(problems.solvers):
        own = frame[frame["solver"] == solver]
        solved = []
        for settings in ("default", "high_accuracy"):
            limit = problems.tolerances[settings]
            part = own[own["settings"] == settings]
            worst = part[["primal_residual", "dual_residual", "duality_gap"]].astype(float).fillna(np.inf)
            solved.append(100 * float((part["found"] & (worst < limit.primal).all(axis=1)).mean()))
        try:
            one_shot, live = (ours(f"{route}/{solver}", problems.cases) for route in ("qpsolvers", "qp"))
        except (NotInstalled, LookupError):
            continue
        theirs_us = 1e6 * float(own[own["settings"] == "default"]["runtime"].median())
        right = (100 * one_shot.right, 100 * live.right)
        times_us = (theirs_us, one_shot.call_us, live.call_us)
        rows.append([solver, *map(three, (*solved, *right, *times_us))])
    return rows


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
