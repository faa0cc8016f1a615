"""The price of limits that come with the call: ``python docs/studies/limits_price.py [VEHICLE]``.

CPU time of a call whose demand and limits are new, over that of a call whose demand alone is new, for every
method; and, for the soft solvers, the share of a call that proving its answer takes. Calls take turns, and
the least of many rounds counts. The study prints two tables of docs/limits.md.
"""

import sys
from collections import deque
from collections.abc import Callable
from functools import partial
from time import thread_time_ns
from typing import Any

import numpy as np

from alloc import Label, NotApplicable, build, catalogue, load_vehicle
from alloc.allocation import FloatArray
from alloc.formulations import Family
from alloc.qp import pose_soft
from alloc.qp.stationarity import Stationarity
from bench.demands import build_demands
from bench.results.text import percent, table, three

N, ROUNDS = 200, 15
GOAL = 1.3
"""What new bounds may cost a live solver, over its call with the old ones."""


def microseconds(calls: dict[str, Callable[[], Any]], each: int) -> dict[str, float]:
    """CPU time of one of ``each`` calls [us], the least of ROUNDS in which all take turns."""
    least = dict.fromkeys(calls, np.inf)
    for _ in range(ROUNDS):
        for name, call in calls.items():
            start = thread_time_ns()
            call()
            least[name] = min(least[name], (thread_time_ns() - start) / each / 1e3)
    return least


def called(allocate: Callable[..., Any], *arguments: list[FloatArray]) -> None:
    """Call it with each of the arguments in turn."""
    deque(map(allocate, *arguments), maxlen=0)


def main(arguments: list[str]) -> None:
    """Print both tables."""
    vehicle = load_vehicle(arguments[0] if arguments else "bluerov2-heavy")
    demands = build_demands("slew", vehicle, 1, N)
    able = np.flatnonzero(demands.labels != Label.INFEASIBLE)
    assert demands.f_min is not None
    assert demands.f_max is not None
    taus, lows, highs = (list(side[able]) for side in (demands.taus, demands.f_min, demands.f_max))
    print(f"{vehicle.name}, {len(taus)} attainable demands of slew; CPU time of a call [us]\n")
    rows, proofs = [], []
    for entry in catalogue():
        if entry.missing or entry.family is Family.ONE_SHOT:
            continue
        try:
            allocate = build(entry.name, vehicle)
        except NotApplicable:
            continue
        calls: dict[str, Callable[[], Any]] = {
            "fixed": partial(called, allocate, taus),
            "moving": partial(called, allocate, taus, lows, highs),
        }
        time = microseconds(calls, len(taus))
        ratio = time["moving"] / time["fixed"]
        missed = entry.family is Family.LIVE and ratio > GOAL
        rows.append((entry.name, three(time["fixed"]), three(time["moving"]), three(ratio) + " (!)" * missed))
        if entry.family is Family.SOFT:
            proofs.append((entry.name, time["fixed"]))
    print(table(("method", "demand new", "demand and limits new", "ratio"), rows))
    posed = pose_soft(vehicle)
    proof = Stationarity(posed.qp, posed.unit)
    F, _ = build("qp-soft/daqp", vehicle).many(taus)
    B, X = posed.scaled(np.array(taus), F)
    m = len(posed.working)
    bounds = posed.qp.lb[:m], posed.qp.ub[:m]
    answers = list(zip(X[:, :m], B, strict=True))
    time = microseconds({"proof": lambda: [proof.distance(x, b, *bounds) for x, b in answers]}, len(answers))
    print(table(
        ("method", "call [us]", "its proof [us]", "share"),
        [(name, three(call), three(time["proof"]), percent(time["proof"] / call)) for name, call in proofs],
    ))  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1:])
