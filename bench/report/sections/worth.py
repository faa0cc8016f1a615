"""Report section: for each vehicle the few methods worth considering."""

from bench.report.readme import lost, not_counted, served
from bench.report.verdict import loop_of
from bench.results.columns import Row
from bench.results.ranking import (
    best,
    complete,
    exact,
    objection,
    optimal,
    own_without_time,
    right,
    worth_considering,
)
from bench.results.rows import Run
from bench.results.sizing import sizes
from bench.results.text import counted, plain, table, three

HEADERS = ("method", "answers", "median [µs]", "p99.9 [µs]", "wrench lost, worst", "served", "memory [MB]")

MEDIANS = " A median is over batches of calls: on a log, whose calls differ, it is near their mean."


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle and log: what none beats in time and loss, and what it is held against."""
    parts = []
    first = {size.vehicle: size.method for size in reversed(sizes(run, loop_of(run)))}
    for vehicle in run.vehicles:
        for demands in run.leading(vehicle):
            measured = best(run, vehicle, demands)
            rows = worth_considering(measured, first.get(vehicle, ""))
            gone = own_without_time(run, vehicle, demands)
            lines = [*(_line(run, row) for row in rows), *map(_not_measured, gone)]
            if lines:
                parts += [f"### {plain(vehicle)}, {plain(demands)} demands\n", table(HEADERS, lines)]
                parts += left_out(len(measured) - len(rows))
        if capability := run.capability(vehicle):
            parts += [f"{plain(line)}.\n" for line in not_counted(capability)]
    if not parts:
        return ""
    own = any(method.plugin for method in run.record.methods)
    logs = any(run.given(vehicle, demands) for vehicle in run.vehicles for demands in run.leading(vehicle))
    which = (
        "What to take first, what no other method beats in both time and loss, the fastest exact one in plain"
        " Python and by a solver, and the closed form and the rule of practice they are held against."
        " *Served* is the share of what the vehicle can do that is delivered within 1 %;"
        " memory is of the process."
        f"{' What you brought has a row whatever it is worth.' if own else ''}"
        f"{MEDIANS if logs else ''}\n"
    )
    return "\n".join(["## Methods worth considering\n", which, *parts])


def answers(row: Row) -> str:
    """Answers of a row in words; near an optimum where only a solver's tolerance misses it."""
    title = row.title
    if not right(row):
        return f"wrong: {objection(row)}"
    if not optimal(row) or exact(row):
        return title
    return f"near {title}" if complete(row) else f"aims at {title}, misses some that can be met"


def left_out(n: int) -> list[str]:
    """A line below a table of report.md that lacks ``n`` methods; none where it has all."""
    return [f"Not shown: {counted(n, 'method')}, in `details.md`.\n"] if n else []


def _not_measured(row: Row) -> list[str]:
    also = f"; wrong: {row.wrong}" if row.wrong else ""  # of what it was asked beside
    return [row.label, f"{row.status}: {row.reason}{also}", *[""] * (len(HEADERS) - 2)]


def _line(run: Run, row: Row) -> list[str]:
    times = [three(row.call_p50_us), three(run.tail_us(row, 0.999))]
    return [row.label, answers(row), *times, lost(row), served(run, row.vehicle, row), three(row.peak_rss_MB)]
