"""What each solver makes of 10,000 hard cases: ``python docs/studies/solvers.py [cases] [methods…]``.

The study prints the tables of ``docs/solvers.md`` in about five minutes. It exits with 1 if any status is not
true of its answer.
"""

import sys
from fnmatch import fnmatchcase
from itertools import product
from typing import NamedTuple

import numpy as np

from alloc import Allocation, Label, Status, Vehicle, build, catalogue, list_vehicles, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.discovery import Entry
from alloc.formulations import Formulation, find_formulation
from alloc.formulations.hard import FORMULATION as HARD
from alloc.formulations.soft import FORMULATION as SOFT
from bench.demands import build_demands

SETS = (("hard", 0.6), ("boundary", 0.2), ("active", 0.2))
"""Demand sets, and their share of the cases."""
SEED = 2004
INSIDE = 5e-6
"""A demand counts as attainable from alpha* = 1 + this on. The ``boundary`` set starts at 1e-5. Within 1e-6,
the tolerance of what counts as met, either status is right."""


class HardCases(NamedTuple):
    """A vehicle's demands with the exact answers.

    Attributes
    ----------
    vehicle : the vehicle, whole or with a thruster off
    taus : (N, k) demands [N, N m]
    attainable : (N,) demands that must be answered
    infeasible : (N,) demands that have no answer
    exact : (N, n) exact answers [N], NaN where there is none
    """

    vehicle: Vehicle
    taus: FloatArray
    attainable: BoolArray
    infeasible: BoolArray
    exact: FloatArray


class Tally(NamedTuple):
    """Result of one method, start and level over all cases: a row of the table.

    Attributes
    ----------
    lies : answers that are not what their status says
    solved, partial : share of attainable demands with that status [%]
    failed_after_failure : share without thrusts, of attainable demands right after another failure [%]
    failed_else : share without thrusts, of all other attainable demands [%]
    recognised : share of infeasible demands with that status [%]
    distance_solved, distance_partial : largest distance to the exact answer, over the largest limit [-]
    iterations : most iterations of any answer
    """

    lies: int
    solved: float
    partial: float
    failed_after_failure: float
    failed_else: float
    recognised: float
    distance_solved: float
    distance_partial: float
    iterations: int


def main(arguments: list[str]) -> int:
    """Print one line for each method, start and level."""
    n = int(arguments[0]) if arguments else 10_000
    wanted = tuple(arguments[1:]) or ("*",)
    by_formulation = {HARD.name: cases(n, HARD), SOFT.name: cases(n, SOFT)}
    print(f"{sum(len(case.taus) for case in by_formulation[HARD.name])} demands, seed {SEED}\n")
    columns = ("method", "start", "level", *Tally._fields)
    print("|", " | ".join(columns), "|\n|" + "---|" * len(columns))
    lied = 0
    for entry in catalogue():
        if entry.missing or not entry.solver or not any(fnmatchcase(entry.name, name) for name in wanted):
            continue
        for start, level in product(entry.starts, entry.levels):
            tally = tallied(entry, by_formulation[entry.formulation], start, level)
            lied += tally.lies
            row = (entry.name, start, level, *(f"{value:.3g}" for value in tally))
            print("|", " | ".join(row), "|", flush=True)
    return 1 if lied else 0


def cases(n: int, formulation: Formulation) -> list[HardCases]:
    """n demands over all vehicles, whole and with a thruster off; exact answers by the first reference."""
    whole = [load_vehicle(name) for name in list_vehicles()]
    states = whole + [v.with_fault(0) for v in whole]
    made = []
    for vehicle in states:
        sets = [s for s in SETS if s[0] != "active" or vehicle.nullity]
        drawn = [build_demands(name, vehicle, SEED, round(share * n / len(states))) for name, share in sets]
        taus = np.concatenate([d.taus for d in drawn])
        alpha = np.concatenate([d.alpha for d in drawn])
        infeasible = np.concatenate([d.labels for d in drawn]) == Label.INFEASIBLE
        soft = formulation.gives_way
        exact, status = build(formulation.references[0], vehicle).many(taus)
        answered = np.isin(status, (Status.SOLVED, Status.PARTIAL))
        case = HardCases(
            vehicle=vehicle,
            taus=taus,
            attainable=answered & (soft | (alpha >= 1 + INSIDE)),
            infeasible=infeasible & (not soft),
            exact=exact,
        )
        made.append(case)
    return made


def tallied(entry: Entry, cases: list[HardCases], start: str, level: str) -> Tally:
    """Run one method over all cases and count."""
    counts = np.zeros(9)
    distance = {Status.SOLVED: 0.0, Status.PARTIAL: 0.0}
    iterations = 0
    for case in cases:
        allocate = build(entry.name, case.vehicle, start=start, level=level)
        answers = [allocate(tau) for tau in case.taus]
        F = np.array([answer.f for answer in answers])
        status = np.array([answer.status for answer in answers])
        iterations = max(iterations, *(answer.iterations for answer in answers))
        failed = np.isin(status, (Status.INFEASIBLE, Status.NOT_CONVERGED))
        after = np.concatenate([[False], failed[:-1]])
        ok = case.attainable
        masks = (
            ok,
            ok & (status == Status.SOLVED),
            ok & (status == Status.PARTIAL),
            ok & after,
            ok & after & failed,
            ok & ~after & failed,
            case.infeasible,
            case.infeasible & (status == Status.INFEASIBLE),
            lies(entry, case, answers),
        )
        counts += [mask.sum() for mask in masks]
        away = np.abs(F - case.exact).max(axis=1) / case.vehicle.f_scale
        for kind in distance:
            distance[kind] = max(distance[kind], away[ok & (status == kind)].max(initial=0.0))
    can, solved, partial, after_n, after_failed, else_failed, cannot, recognised, lied = counts
    return Tally(
        lies=int(lied),
        solved=100 * solved / can,
        partial=100 * partial / can,
        failed_after_failure=100 * after_failed / max(after_n, 1),
        failed_else=100 * else_failed / max(can - after_n, 1),
        recognised=100 * recognised / max(cannot, 1),
        distance_solved=distance[Status.SOLVED],
        distance_partial=distance[Status.PARTIAL],
        iterations=iterations,
    )


def lies(entry: Entry, case: HardCases, answers: list[Allocation]) -> BoolArray:
    """Answers that are not what their status says."""
    lied = np.zeros(len(answers), dtype=bool)
    v = case.vehicle
    for i, (tau, (f, status, *_)) in enumerate(zip(case.taus, answers, strict=True)):
        if status in (Status.INFEASIBLE, Status.NOT_CONVERGED):
            lied[i] = not np.isnan(f).all() or (status == Status.INFEASIBLE and case.attainable[i])
            continue
        inside = ((v.f_min <= f) & (f <= v.f_max)).all()  # False for NaN
        met = (np.abs(v.TP @ f - tau) <= WRENCH_TOLERANCE * v.wrench_scale).all()
        if not find_formulation(entry.formulation).gives_way:
            met &= not case.infeasible[i]
        lied[i] = not inside or (status == Status.SOLVED and not met)
    return lied


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
