"""Report section: one flight, before and after a thruster fails, method by method."""

from alloc.allocation import WRENCH_TOLERANCE
from bench.results.columns import Row
from bench.results.ranking import best
from bench.results.rows import Run
from bench.results.text import percent, plain, table, three

BEFORE, AFTER = "mission", "mission-fault"

ROUNDING_DEG = 1e-4
"""Largest turn [deg] of a wrench that is met within WRENCH_TOLERANCE: 1e-6 rad."""

HEADERS = (
    "method",
    "within 1 %, before",
    "after",
    "wrench lost, worst, before",
    "after",
    "worst turn [°], before",
    "after",
)


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle whose flight was measured before and after a failure."""
    parts = []
    for vehicle in run.vehicles:
        before = {row.method: row for row in best(run, vehicle, BEFORE)}
        for degraded in _degraded(run, vehicle):
            after = {row.method: row for row in best(run, degraded, AFTER)}
            lines = [[name, *_numbers(row, after[name])] for name, row in before.items() if name in after]
            if lines:
                parts += [f"### {plain(vehicle)}, then {plain(degraded)}\n", table(HEADERS, lines)]
    if not parts:
        return ""
    title = (
        "## Through a failure\n\n"
        f"{_flown(run)} of waypoints in a current, then as many after the thruster whose loss costs most"
        " (and no rank, where that can be had) has failed. Each method answers the same demands; one"
        " without an answer is lost whole.\n"
    )
    return "\n".join([title, *parts])


def _flown(run: Run) -> str:
    """How many demands of the flight were asked, and their time: a run asks as many as of any other set."""
    halves = [p for p in run.record.problems if p.demands in (BEFORE, AFTER)]
    most = max((p.n_demands for p in halves), default=0)
    seconds = max((p.n_demands / p.rate_hz for p in halves if p.rate_hz), default=None)
    return f"{most} demands" + ("" if seconds is None else f" ({three(seconds)} s)")


def _degraded(run: Run, vehicle: str) -> list[str]:
    """Vehicles that are this one with a single fault, and were flown."""
    flown = {row.vehicle for row in run.rows if row.demands == AFTER}
    return sorted(
        name for name in flown if run.whole(name) == vehicle and len(run.problems[name].faults) == 1
    )


def _numbers(before: Row, after: Row) -> list[str]:
    within = [percent(row.within_1pct_share) for row in (before, after)]
    lost = [percent(_lost(row)) for row in (before, after)]
    turned = [three(_above(row.direction_error_max_deg, ROUNDING_DEG)) for row in (before, after)]
    return [*within, *lost, *turned]


def _lost(row: Row) -> float | None:
    # A demand without an answer delivers nothing.
    if (row.answered_share or 0.0) < 1.0:
        return 1.0
    return _above(row.lost_wrench_max, WRENCH_TOLERANCE)


def _above(value: float | None, floor: float) -> float | None:
    return 0.0 if value is not None and value <= floor else value
