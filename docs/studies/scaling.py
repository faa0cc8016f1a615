"""The effect of scaling: each solver's defaults on a problem in N and N m, and on the scaled problem.

``python docs/studies/scaling.py [vehicle]`` prints the table of ``docs/solvers.md``.
"""

import sys

import numpy as np

from alloc import Status, Vehicle, build, load_vehicle, solvers
from alloc.allocation import FloatArray
from alloc.live.allocator import Live
from alloc.qp import pose_hard
from bench.demands import build_demands
from bench.results.text import table

N = 1000


def main(arguments: list[str]) -> None:
    """Print one line for each solver: attainable demands solved, worst distance to the optimum."""
    vehicle = load_vehicle(arguments[0] if arguments else "supply-vessel")
    taus = build_demands("active", vehicle, 2004, N).taus
    exact, _ = build("nullspace", vehicle).many(taus)
    print(f"{vehicle.name}, {N} active demands, start cold, level default\n")
    rows = [
        [name, *(cell for scaled in (False, True) for cell in outcome(name, vehicle, scaled, taus, exact))]
        for name in solvers.names()
        if not solvers.missing(name)
    ]
    print(table(("solver", "solved in N, %", "distance", "solved scaled, %", "distance"), rows))


def outcome(
    name: str, vehicle: Vehicle, scaled: bool, taus: FloatArray, exact: FloatArray
) -> tuple[str, str]:
    """Share of SOLVED [%], and the largest distance among the finite answers, over the largest limit."""
    posed = pose_hard(vehicle, scaled)
    solve = solvers.load(name).prepare(posed.qp, "cold", "default")
    F, status = Live("hard", vehicle, posed, solve, 1.0, name).many(taus)
    distance = np.abs(F - exact).max(axis=1) / vehicle.f_scale
    answered = np.isfinite(distance)
    worst = f"{distance[answered].max():.1g}" if answered.any() else "no answer"
    return f"{100 * np.mean(status == Status.SOLVED):.3g}", worst


if __name__ == "__main__":
    main(sys.argv[1:])
