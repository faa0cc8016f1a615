"""Report section: demands in a row and limits that move; what is lost, and what a start is worth."""

from bench.record import Problem
from bench.results.columns import Row
from bench.results.ranking import largest_loss
from bench.results.rows import Run
from bench.results.text import percent, plain, table, three

INTRODUCTION = """## Demands in a row, and limits that move

Each demand follows the one before it in time, and where limits move each has limits of its own: what slew
rates leave around the last thrusts, or what a battery's voltage gives. *Cold* and *warm* are the median call
with a new solver object each time, and with the last answer as first guess, over that of the same object
without a guess. *Lost* is the largest share of a demanded wrench that is not delivered by thrusts cut at
their limits, over all demands: also of those that no thrusts meet.
"""

HEADERS = (
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


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each set of a vehicle whose demands are a sequence or have limits of their own."""
    asked = sequences(run)
    parts = [part for one in asked for part in (f"### {plain(title(one))}\n", of(run, one))]
    return "\n".join([INTRODUCTION, *parts]) if parts else ""


def sequences(run: Run) -> list[Problem]:
    """The problems that this section is about, in the order of vehicles and sets."""
    wanted = [p for p in run.record.problems if p.moving or p.rate_hz is not None]
    return [p for p in wanted if p.vehicle in run.by_vehicle and run.of(p.vehicle, p.demands)]


def title(problem: Problem) -> str:
    """Title with vehicle, set, number of demands of each kind, and limits that move."""
    kinds = ", ".join(f"{count} {name}" for name, count in problem.labels.items())
    limits = "limits of each" if problem.moving else "fixed limits"
    return f"{problem.vehicle}, {problem.demands}: {problem.n_demands} demands ({kinds}), {limits}"


def of(run: Run, problem: Problem) -> str:
    """The table of one problem: a line for each method and level, fastest first."""
    starts: dict[tuple[str, str], dict[str, Row]] = {}
    for row in run.of(problem.vehicle, problem.demands):
        if not row.failed and row.measured.cells[0].formulation and row.call_p50_us is not None:
            starts.setdefault((row.method, row.measured.key.level), {})[row.start] = row
    lines = [(by.get("reused") or next(iter(by.values())), by) for by in starts.values()]
    lines.sort(key=lambda line: line[0].call_p50_us or 0.0)
    return table(HEADERS, [_line(row, by_start) for row, by_start in lines])


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
