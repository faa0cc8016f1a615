"""Which start and level represents a method, and which rows are right, complete, optimal and exact."""

from alloc import find_formulation
from bench.results.columns import Row
from bench.results.rows import Run

EXACT_WITHIN = 1e-6
"""Largest measured distance to the optimum, over the largest limit, at which answers count as exact, whatever
distance was promised. ``tight`` settings are chosen to reach it."""
ROUNDING = 1e-9
"""Shares that differ by no more than this count as equal: it is the rounding of a ratio of counts."""


def right(row: Row) -> bool:
    """Whether a row was measured and no answer in it is wrong or farther off than promised."""
    return not row.failed and row.agrees != "no" and not row.wrong


def complete(row: Row) -> bool:
    """Whether as many demands were solved as are attainable."""
    solved = row.solved_fraction
    return solved is not None and solved >= row.attainable - ROUNDING


def optimal(row: Row) -> bool:
    """Whether a row's formulation serves every attainable demand at least effort (eq. 4-5)."""
    return find_formulation(row.formulation).optimal


def exact(row: Row) -> bool:
    """Whether all of a row's answers are the constrained optimum, within EXACT_WITHIN."""
    distance = row.distance_relative
    near = distance is not None and distance <= EXACT_WITHIN
    return near and optimal(row) and complete(row) and right(row)


def best(run: Run, vehicle: str, demands: str) -> list[Row]:
    """One measured row for each method on that demand set, fastest first.

    A method is represented by the fastest of its starts and levels that are right on all of the vehicle's
    demand sets, exact ones before others. Where none is right on all sets, the fastest represents it.
    """
    wrong = {row.label for row in run.of(vehicle) if not right(row)}
    chosen: dict[str, tuple[bool, bool, float, Row]] = {}
    for row in run.of(vehicle, demands):
        time = row.call_p50_us
        if row.failed or time is None or not row.cells[0].formulation:  # a yardstick has no formulation
            continue
        rank = (row.label in wrong, not exact(row), time, row)
        if row.method not in chosen or rank[:3] < chosen[row.method][:3]:
            chosen[row.method] = rank
    return [row for *_, row in sorted(chosen.values(), key=lambda rank: rank[2])]
