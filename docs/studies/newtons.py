"""Worth of each solver's "solved" and "infeasible" to who gives it newtons as they are: a table by vehicle.

``python docs/studies/keep.py newtons`` asks each solver, at its own settings, the
same demands in newtons and in the units of this suite, and believes what it says: none of the checks that an
allocator makes. ``python docs/studies/page_tables.py newtons`` puts the sums into docs/solvers.md.
"""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle, solvers
from alloc.allocation import FloatArray
from alloc.qp import pose_hard
from bench.demands import build_demands
from bench.results.text import table

VEHICLES = ("ukwial", "bluerov2", "bluerov2-heavy", "supply-vessel", "tiburon")
DEMANDS = {"active": 12, "inactive": 14, "infeasible": 10}
"""Demands of each set for each vehicle: 60, 70 and 50 in all."""
SEED = 2004
RIGHT = 1e-3
"""Largest distance of a right answer to the exact one, relative to the largest limit [-]."""
CLAIMS = ("solved, right", "solved, wrong", "infeasible", "nothing")
ASKED = {"attainable": CLAIMS, "beyond reach": CLAIMS[1:]}
"""Claims that are possible, for demands that can be met and for others."""
UNITS = ("newtons", "scaled")
HEADERS = ("solver", "vehicle", "units", *(f"{asked}: {said}" for asked in ASKED for said in ASKED[asked]))
PAGE = Path(__file__).parents[2] / "results/studies/newtons.md"


def claims(name: str, vehicle: Vehicle, scaled: bool) -> Counter[str]:
    """Claims about the demands on a vehicle: ``attainable: solved, right`` and so on, counted."""
    posed, solver = pose_hard(vehicle, scaled=scaled), solvers.load(name)
    found = Counter[str]()
    exact = build("nullspace", vehicle)
    try:
        solve = solver.prepare(posed.qp, solvers.default_start(solver), next(iter(solver.SETTINGS)))
    except (NotApplicable, RuntimeError, ValueError):
        solve = None
    for demands, n in DEMANDS.items():
        asked = "beyond reach" if demands == "infeasible" else "attainable"
        taus = build_demands(demands, vehicle, SEED, n).taus
        for tau, best in zip(taus, exact.many(taus)[0], strict=True):
            said = "nothing"
            if solve is not None:
                try:
                    x, status, *_ = solve(posed.b_of_tau @ tau, posed.qp.lb, posed.qp.ub)
                    said = claim(status, x * posed.unit, best / vehicle.f_scale, vehicle.f_scale, asked)
                except (RuntimeError, ValueError, ArithmeticError):
                    said = "nothing"
            found[f"{asked}: {said}"] += 1
    return found


def claim(status: Status, f: FloatArray, best: FloatArray, unit: float, asked: str) -> str:
    """One of ``CLAIMS`` for a status and its thrusts f (n,) [N], the best (n,) in units of ``unit`` [N]."""
    if status is Status.INFEASIBLE:
        return "infeasible"
    if status is not Status.SOLVED:
        return "nothing"
    right = asked == "attainable" and np.abs(f / unit - best).max() <= RIGHT
    return "solved, right" if right else "solved, wrong"


def rows() -> Iterator[list[str]]:
    """A row for each solver, vehicle and kind of units."""
    for name in solvers.names():
        if solvers.missing(name):
            continue
        for vehicle in map(load_vehicle, VEHICLES):
            for units in UNITS:
                found = claims(name, vehicle, scaled=units == "scaled")
                yield [name, vehicle.name, units, *(str(found[header]) for header in HEADERS[3:])]


def summed(page: str) -> str:
    """Table of all vehicles together, a row for each solver, from the text of ``PAGE``."""
    found: dict[str, dict[tuple[str, str], Counter[str]]] = {}
    for line in page.splitlines():
        name, _, units, *counts = [cell.strip() for cell in line.strip("|").split("|")] + ["", ""]
        if units not in UNITS:
            continue
        own = found.setdefault(name, {})
        for header, count in zip(HEADERS[3:], counts, strict=False):
            asked, _, said = header.partition(": ")
            own.setdefault((asked, units), Counter())[said] += int(count)
    keys = [(asked, units) for asked in ASKED for units in UNITS]
    lines = [
        [name, *("/".join(map(str, own[key].values())) for key in keys)]
        for name, own in sorted(found.items())
    ]
    return table(("solver", *(f"{asked}, {units}" for asked, units in keys)), lines, markdown=True)


if __name__ == "__main__":
    print(table(HEADERS, rows(), markdown=True))
