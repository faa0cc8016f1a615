"""The price of proving INFEASIBLE: ``python docs/studies/proof_price.py [VEHICLE]``.

CPU time of a call that a solver refuses, with the proof and without it, for each solver that recognises
infeasible demands, and what preparing the proof takes when the allocator is built. Calls with and without it
take turns, and the least of many rounds counts. The study prints a table of docs/solvers.md.
"""

import sys
from collections.abc import Callable
from functools import partial
from time import thread_time_ns

import numpy as np

from alloc import Status, build, load_vehicle, solvers
from alloc.live.allocator import Live
from alloc.reach.beyond import beyond
from bench.demands import build_demands
from bench.results.text import percent, table, three
from limits_price import called, microseconds

N = 40
BUILDS = 5


def main(arguments: list[str]) -> None:
    """Print a line for each solver that says INFEASIBLE of at least half of N demands."""
    vehicle = load_vehicle(arguments[0] if arguments else "bluerov2-heavy")
    taus = build_demands("infeasible", vehicle, 2004, N).taus
    rows = []
    for name in solvers.names():
        if solvers.missing(name):
            continue
        proven, believed = build(f"qp/{name}", vehicle), build(f"qp/{name}", vehicle)
        assert isinstance(proven, Live)
        assert isinstance(believed, Live)
        refused = [tau for tau in taus if proven(tau).status is Status.INFEASIBLE]
        if 2 * len(refused) < N:
            rows.append([name, *["-"] * 4])
            continue
        believed._beyond = lambda *_: True
        calls: dict[str, Callable[[], None]] = {
            "with": partial(called, proven, refused),
            "without": partial(called, believed, refused),
        }
        us = microseconds(calls, len(refused))
        added = us["with"] - us["without"]
        rows.append([name, *map(three, (us["without"], us["with"], added)), percent(added / us["without"])])
    print(f"{vehicle.name}, {N} infeasible demands, tight; CPU time of a refused call [us]\n")
    print(table(("solver", "without", "with the proof", "the proof", "of a call, %"), rows))
    print(f"\npreparing the proof: {prepared_ms(vehicle.name):.2g} ms")


def prepared_ms(name: str) -> float:
    """CPU time of preparing the proof for a vehicle just loaded, the least of BUILDS [ms]."""
    least = np.inf
    for _ in range(BUILDS):
        vehicle = load_vehicle(name)
        start = thread_time_ns()
        beyond(vehicle)
        least = min(least, (thread_time_ns() - start) / 1e6)
    return float(least)


if __name__ == "__main__":
    main(sys.argv[1:])
