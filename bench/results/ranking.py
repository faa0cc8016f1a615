"""Which start and level of a method stands for it, and which methods are exact."""

from alloc import find_formulation
from bench.results.columns import Row
from bench.results.rows import Run

EXACT_WITHIN = 1e-6
"""Largest distance to the optimum, over the largest limit, at which answers count as exact: what ``tight``
settings are chosen for. It is the distance that was found, not the one that was promised."""
ROUNDING = 1e-9
"""By how much two shares may differ and still count as equal: rounding of a ratio of counts."""


def right(row: Row) -> bool:
    """Whether a row was measured and no answer in it is wrong or farther off than promised."""
    return not row.failed and row.agrees != "no" and not row.wrong


def complete(row: Row) -> bool:
    """Whether as many demands were solved as are attainable: giving up is no answer."""
    solved = row.solved_fraction
    return solved is not None and solved >= row.attainable - ROUNDING


def optimal(row: Row) -> bool:
    """Whether a row answers an optimum that serves every attainable demand at least effort (eq. 4-5)."""
    return find_formulation(row.formulation).optimal


def exact(row: Row) -> bool:
    """Whether a row's answers are the constrained optimum, all of them, found within EXACT_WITHIN of it."""
    distance = row.distance_relative
    near = distance is not None and distance <= EXACT_WITHIN
    return near and optimal(row) and complete(row) and right(row)


def best(run: Run, vehicle: str, demands: str) -> list[Row]:
    """One row a method on that demand set, fastest first, of those that were measured.

    The start and level chosen are right on all of the vehicle's demand sets, exact if any of them
    is, and then the fastest; where none is right everywhere, the fastest is shown all the same.
    """
    wrong = {row.label for row in run.of(vehicle) if not right(row)}
    chosen: dict[str, tuple[bool, bool, float, Row]] = {}
    for row in run.of(vehicle, demands):
        time = row.call_p50_us
        if row.failed or time is None or not row.cells[0].formulation:  # yardsticks answer nothing
            continue
        rank = (row.label in wrong, not exact(row), time, row)
        if row.method not in chosen or rank[:3] < chosen[row.method][:3]:
            chosen[row.method] = rank
    return [row for *_, row in sorted(chosen.values(), key=lambda rank: rank[2])]
