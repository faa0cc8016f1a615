"""Worth of each solver's "solved" and "infeasible" to who gives it newtons as they are: a table by vehicle.

``python docs/studies/keep.py newtons`` asks each solver, at its own settings, the
same demands in newtons and in the units of this suite, and believes what it says: none of the checks that an
allocator makes. ElastiQP is asked at a price of 1e4 too, of a broken limit and of a missed wrench; and
PrimalSolver 0.1.3, no solver of this suite, where it is installed (``pip install primalsolver``).
``python docs/studies/page_tables.py newtons`` puts the sums of solvers into docs/solvers.md.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter

import numpy as np

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle, solvers
from alloc.allocation import FloatArray
from alloc.qp import QP, pose_hard
from alloc.qp.problem import OneSided
from alloc.solvers import Answer, Solve
from alloc.solvers.elastiqp import prepare_rows
from bench.demands import build_demands
from bench.results.text import table, three

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
PRICE, KEPT = 1e4, 1e12
"""ElastiQP's price of what may give way where it is asked so, and of what may not [-]."""


def elastic(gives_way: str) -> Callable[[QP], Solve]:
    """Preparation of ElastiQP where limits, or the wrench, give way at ``PRICE``."""

    def prepare(qp: QP) -> Solve:
        sides, p = OneSided(qp), len(qp.A)
        prices = (KEPT, PRICE) if gives_way == "limits" else (PRICE, KEPT)
        rows = np.vstack([qp.A, -qp.A, qp.one_sided[0]])

        def right(b: FloatArray, lb: FloatArray, ub: FloatArray) -> FloatArray:
            sides.put(b, lb, ub)
            return np.concatenate([b, -b, sides.right[p:]])

        each = np.repeat(prices, [2 * p, len(rows) - 2 * p])
        solve = prepare_rows(qp.H, rows, right(np.zeros(p), qp.lb, qp.ub), each, "default")
        return lambda *call: solve(right(*call))

    return prepare


def primal(qp: QP) -> Solve:
    """Preparation of PrimalSolver, which builds a model for each call."""
    known = import_module("primalsolver")
    BK, SOLSTA, Model = known.BK, known.SOLSTA, known.Model
    said = {SOLSTA.OPTIMAL: Status.SOLVED, SOLSTA.PRIM_INFEAS_CER: Status.INFEASIBLE}
    m, p = len(qp.g), len(qp.A)

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        with Model(maxcon=p, maxvar=m) as model:
            model.obj(list(range(m)), qp.g.tolist())
            for i in range(m):
                model.var_bounds(i, BK.RA, lb[i].item(), ub[i].item())
                for j in range(i + 1):
                    model.qobj_ij(i, j, qp.H[i, j].item())
            for j in range(p):
                for i in range(m):
                    model.a_ij(j, i, qp.A[j, i].item())
                model.con_bounds(j, BK.FX, b[j].item(), b[j].item())
            found = model.solve()
        return Answer(np.array(found.x), said.get(found.solsta, Status.NOT_CONVERGED))

    return solve


def usual(name: str) -> Callable[[QP], Solve]:
    """Preparation of a solver of that name at its own settings."""
    solver = solvers.load(name)
    level = next(iter(solver.SETTINGS))
    return lambda qp: solver.prepare(qp, solvers.default_start(solver), level)


def claims(prepare: Callable[[QP], Solve], vehicle: Vehicle, scaled: bool) -> tuple[Counter[str], float]:
    """Claims about demands on a vehicle: ``attainable: solved, right`` and so on; median call [us]."""
    posed = pose_hard(vehicle, scaled=scaled)
    found, times = Counter[str](), list[float]()
    exact = build("nullspace", vehicle)
    try:
        solve = prepare(posed.qp)
    except (NotApplicable, RuntimeError, ValueError):
        solve = None
    for demands, n in DEMANDS.items():
        asked = "beyond reach" if demands == "infeasible" else "attainable"
        taus = build_demands(demands, vehicle, SEED, n).taus
        for tau, best in zip(taus, exact.many(taus)[0], strict=True):
            said = "nothing"
            if solve is not None:
                started = perf_counter()
                try:
                    x, status, *_ = solve(posed.b_of_tau @ tau, posed.qp.lb, posed.qp.ub)
                    times.append(1e6 * (perf_counter() - started))
                    said = claim(status, x * posed.unit, best / vehicle.f_scale, vehicle.f_scale, asked)
                except (RuntimeError, ValueError, ArithmeticError):
                    said = "nothing"
            found[f"{asked}: {said}"] += 1
    return found, float(np.median(times)) if times else np.nan


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
    asked = {name: usual(name) for name in solvers.names() if not solvers.missing(name)}
    if "elastiqp" in asked:
        asked |= {f"elastiqp, {side} elastic": elastic(side) for side in ("limits", "wrench")}
    if find_spec("primalsolver"):
        asked["primalsolver"] = primal
    for name, prepare in asked.items():
        for vehicle in map(load_vehicle, VEHICLES):
            for units in UNITS:
                found, call_us = claims(prepare, vehicle, scaled=units == "scaled")
                counts = (str(found[header]) for header in HEADERS[3:])
                yield [name, vehicle.name, units, *counts, three(call_us)]


def summed(page: str) -> str:
    """Table of all vehicles together, a row for each solver, from the text of ``PAGE``."""
    found: dict[str, dict[tuple[str, str], Counter[str]]] = {}
    for line in page.splitlines():
        name, _, units, *counts = [cell.strip() for cell in line.strip("|").split("|")] + ["", ""]
        if units not in UNITS or name not in solvers.names():
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
    print(table((*HEADERS, "call [µs]"), rows(), markdown=True))
