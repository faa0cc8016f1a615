"""Report section: for each vehicle the few methods worth considering."""

from bench.report.readme import loss_text, served_text, uncounted_methods
from bench.report.verdict import opening_loop
from bench.results.columns import Row
from bench.results.ranking import (
    best_rows,
    is_complete,
    is_exact,
    is_optimal,
    is_right,
    objection,
    shortlist,
    unmeasured_plugins,
)
from bench.results.rows import Run
from bench.results.sizing import sizes
from bench.results.text import plain, plural, table, three

HEADERS = ("method", "answers", "median [µs]", "p99.9 [µs]", "wrench lost, worst", "served", "memory [MB]")

MEDIANS = " A median is over batches of calls: on a log, whose calls differ, it is near their mean."


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle and log: what none beats in time and loss, and what it is held against."""
    parts = []
    first = {size.vehicle: size.method for size in reversed(sizes(run, opening_loop(run)))}
    for vehicle in run.vehicles:
        for demands in run.leading(vehicle):
            measured = best_rows(run, vehicle, demands)
            rows = shortlist(measured, first.get(vehicle, ""))
            gone = unmeasured_plugins(run, vehicle, demands)
            lines = [*(_line(run, row) for row in rows), *map(_not_measured, gone)]
            if lines:
                parts += [f"### {plain(vehicle)}, {plain(demands)} demands\n", table(HEADERS, lines)]
                parts += omission_note(len(measured) - len(rows))
        if capability := run.capability(vehicle):
            parts += [f"{plain(line)}.\n" for line in uncounted_methods(capability)]
    if not parts:
        return ""
    own = any(method.plugin for method in run.record.methods)
    logs = any(run.given(vehicle, demands) for vehicle in run.vehicles for demands in run.leading(vehicle))
    which = (
        "What to take first, what no other method beats in both time and loss, the fastest exact one in plain"
        " Python and by a solver, and the closed form and the rule of practice to compare them with."
        " *Served* is the share of what the vehicle can do that is delivered within 1 %;"
        " memory is of the process."
        f"{' What you brought has a row whatever it is worth.' if own else ''}"
        f"{MEDIANS if logs else ''}\n"
    )
    return "\n".join(["## Methods worth considering\n", which, *parts])


def answers(row: Row) -> str:
    """Answers of a row in words; near an optimum where only a solver's tolerance misses it."""
    title = row.title
    if not is_right(row):
        return f"wrong: {objection(row)}"
    if not is_optimal(row) or is_exact(row):
        return title
    return f"near {title}" if is_complete(row) else f"aims at {title}, misses some that can be met"


def omission_note(n: int) -> list[str]:
    """A line below a table of report.md that lacks ``n`` methods; none where it has all."""
    return [f"Not shown: {plural(n, 'method')}, in `details.md`.\n"] if n else []


def _not_measured(row: Row) -> list[str]:
    also = f"; wrong: {row.wrong}" if row.wrong else ""  # of what it was asked beside
    return [row.label, f"{row.status}: {row.reason}{also}", *[""] * (len(HEADERS) - 2)]


def _line(run: Run, row: Row) -> list[str]:
    times = [three(row.call_p50_us), three(run.tail_us(row, 0.999))]
    return [
        row.label,
        answers(row),
        *times,
        loss_text(row),
        served_text(run, row.vehicle, row),
        three(row.peak_rss_MB),
    ]
