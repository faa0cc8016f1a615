"""Report sections on demands in a row: limits that move, and one flight through a failure."""

from alloc.allocation import WRENCH_TOLERANCE
from bench.record import Problem
from bench.results.columns import Row
from bench.results.ranking import best_rows, largest_loss
from bench.results.rows import Run
from bench.results.text import percent, plain, table, three

MOVING = """## Demands in a row, and limits that move

Each demand follows the one before it in time, and where limits move each has limits of its own: what slew
rates leave around the last thrusts, or what a battery's voltage gives. *Cold* and *warm* are the median call
with a new solver object each time, and with the last answer as first guess, over that of the same object
without a guess. *Lost* is the largest share of a demanded wrench that is not delivered by thrusts cut at
their limits, over all demands: also of those that no thrusts meet.
"""

MOVING_HEADERS = (
    "method",
    "p50 [µs]",
    "cold",
    "warm",
    "p99 [µs]",
    "within 1 %",
    "lost, worst",
    "solved",
    "beyond limits",
)


def moving(run: Run, drawn: frozenset[str]) -> str:
    """A table for each set of a vehicle whose demands are a sequence or have limits of their own."""
    asked = sequences(run)
    parts = [part for one in asked for part in (f"### {plain(title(one))}\n", sequence_table(run, one))]
    return "\n".join([MOVING, *parts]) if parts else ""


def sequences(run: Run) -> list[Problem]:
    """The problems that this section is about, in the order of vehicles and sets."""
    wanted = [p for p in run.record.problems if p.moving or p.rate_hz is not None]
    return [p for p in wanted if p.vehicle in run.by_vehicle and run.of(p.vehicle, p.demands)]


def title(problem: Problem) -> str:
    """Title with vehicle, set, number of demands of each kind, and limits that move."""
    kinds = ", ".join(f"{count} {name}" for name, count in problem.labels.items())
    limits = "limits of each" if problem.moving else "fixed limits"
    return f"{problem.vehicle}, {problem.demands}: {problem.n_demands} demands ({kinds}), {limits}"


def sequence_table(run: Run, problem: Problem) -> str:
    """The table of one problem: a line for each method and level, fastest first."""
    starts: dict[tuple[str, str], dict[str, Row]] = {}
    for row in run.of(problem.vehicle, problem.demands):
        if not row.failed and row.measured.cells[0].formulation and row.call_p50_us is not None:
            starts.setdefault((row.method, row.measured.key.level), {})[row.start] = row
    lines = [(by.get("reused") or next(iter(by.values())), by) for by in starts.values()]
    lines.sort(key=lambda line: line[0].call_p50_us or 0.0)
    return table(MOVING_HEADERS, [_line(row, by_start) for row, by_start in lines])


def _line(row: Row, by_start: dict[str, Row]) -> list[str]:
    level = f" ({row.measured.key.level})" if row.measured.key.level not in ("-", "tight") else ""
    return [
        row.method + level,
        three(row.call_p50_us),
        *(_ratio(by_start.get(start), row) for start in ("cold", "warm")),
        three(row.call_p99_us),
        percent(row.within_1pct_share),
        percent(largest_loss(row)),
        percent(row.solved_fraction),
        percent(row.limits_violated_share),
    ]


def _ratio(other: Row | None, row: Row) -> str:
    if other is None or other is row or other.call_p50_us is None or row.call_p50_us is None:
        return ""
    return three(other.call_p50_us / row.call_p50_us)


BEFORE, AFTER = "mission", "mission-fault"

ROUNDING_DEG = 1e-4
"""Largest turn [deg] of a wrench that is met within WRENCH_TOLERANCE: 1e-6 rad."""

MISSION_HEADERS = (
    "method",
    "within 1 %, before",
    "after",
    "wrench lost, worst, before",
    "after",
    "worst turn [°], before",
    "after",
)


def mission(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle whose flight was measured before and after a failure."""
    parts = []
    for vehicle in run.vehicles:
        before = {row.method: row for row in best_rows(run, vehicle, BEFORE)}
        for degraded in _degraded(run, vehicle):
            after = {row.method: row for row in best_rows(run, degraded, AFTER)}
            lines = [[name, *_numbers(row, after[name])] for name, row in before.items() if name in after]
            if lines:
                parts += [f"### {plain(vehicle)}, then {plain(degraded)}\n", table(MISSION_HEADERS, lines)]
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
    lost = [percent(_lost_whole(row)) for row in (before, after)]
    turned = [three(_above(row.direction_error_max_deg, ROUNDING_DEG)) for row in (before, after)]
    return [*within, *lost, *turned]


def _lost_whole(row: Row) -> float | None:
    # A demand without an answer delivers nothing.
    if (row.answered_share or 0.0) < 1.0:
        return 1.0
    return _above(row.lost_wrench_max, WRENCH_TOLERANCE)


def _above(value: float | None, floor: float) -> float | None:
    return 0.0 if value is not None and value <= floor else value
