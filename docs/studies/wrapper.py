"""The cost of what is wrapped around each solver: ``python docs/studies/wrapper.py [vehicle]``.

The study prints a table of ``docs/solvers.md``: median CPU time per call, routes and solvers interleaved.
"""

import sys
from collections.abc import Callable
from time import thread_time_ns
from typing import Any

import numpy as np

from alloc import Allocator, build, load_vehicle, solvers
from alloc.allocation import FloatArray, TwoStage
from bench.demands import build_demands
from bench.results.text import table, three

N = 50
ROUNDS = 21
Call = Callable[..., Any]
Calls = dict[str, tuple[Call, list[tuple[FloatArray, ...]]]]
"""By name, a function and the arguments of each of its calls."""


def main(arguments: list[str]) -> None:
    """Print one line for each solver that is installed."""
    vehicle = load_vehicle(arguments[0] if arguments else "bluerov2-heavy")
    taus = build_demands("active", vehicle, 2004, N).taus
    installed = [name for name in solvers.names() if not solvers.missing(name)]
    calls: Calls = {}
    one_argument: list[tuple[FloatArray, ...]] = [(tau,) for tau in taus]
    live: dict[str, Allocator] = {}
    for name in installed:
        allocator = build(f"qp/{name}", vehicle, level="default")
        assert isinstance(allocator, TwoStage)  # every qp/ method is
        live[name] = allocator
        calls[f"one-shot {name}"] = build(f"qpsolvers/{name}", vehicle), one_argument
        calls[f"live {name}"] = allocator, one_argument
        calls[f"binding {name}"] = allocator.solve, [allocator.pose(tau) for tau in taus]
    time = medians(calls)
    print(
        f"{vehicle.name}, {N} active demands, defaults; CPU time of a call [us], median of {ROUNDS} rounds\n"
    )
    rows = []
    for name in sorted(installed, key=lambda name: time[f"live {name}"]):
        own = 1e6 * float(np.median([live[name](tau).solver_s for tau in taus]))
        total, binding = time[f"live {name}"], time[f"binding {name}"]
        share = f"{100 * (1 - own / total):.0f}" if np.isfinite(own) else "-"
        clock = three(own) if np.isfinite(own) else "-"
        shown = (time[f"one-shot {name}"], total, binding)
        rows.append((name, *map(three, shown), clock, share))
    print(table(("solver", "one-shot", "live", "binding", "solver's own clock", "wrapper's share, %"), rows))


def medians(calls: Calls) -> dict[str, float]:
    """Median over rounds of the CPU time of each call [us]; in each round all calls take turns."""
    samples: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, (call, inputs) in calls.items():
            call(*inputs[0])
            start = thread_time_ns()
            for arguments in inputs:
                call(*arguments)
            samples[name].append((thread_time_ns() - start) / len(inputs) / 1e3)
    return {name: float(np.median(values)) for name, values in samples.items()}


if __name__ == "__main__":
    main(sys.argv[1:])
