"""Report section: for each vehicle the few methods worth considering."""

from alloc.formulations import find_formulation
from bench.report.readme import lost, not_counted, served
from bench.report.verdict import loop_of
from bench.results.columns import Row
from bench.results.ranking import best, complete, exact, optimal, right, worth_considering
from bench.results.rows import Run
from bench.results.sizing import sizes
from bench.results.text import plain, table, three

HEADERS = ("method", "answers", "median [µs]", "p99.9 [µs]", "wrench lost, worst", "served", "memory [MB]")


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle and log: what none beats in time and loss, and what it is held against."""
    parts = []
    first = {size.vehicle: size.method for size in reversed(sizes(run, loop_of(run)))}
    for vehicle in run.vehicles:
        for demands in run.leading(vehicle):
            rows = worth_considering(best(run, vehicle, demands), first.get(vehicle, ""))
            lines = [*(_line(run, row) for row in rows), *_not_measured(run, vehicle, demands)]
            if lines:
                parts += [f"### {plain(vehicle)}, {plain(demands)} demands\n", table(HEADERS, lines)]
        if capability := run.capability(vehicle):
            parts += [f"{plain(line)}.\n" for line in not_counted(capability)]
    if not parts:
        return ""
    own = any(method.plugin for method in run.record.methods)
    which = (
        "What to take first, what no other method beats in both time and loss, the fastest exact one in plain"
        " Python and by a solver, and the closed form and the rule of practice they are held against."
        " *Served* is the share of what the vehicle can do that is delivered within 1 %;"
        " memory is of the process."
        f"{' What you brought has a row whatever it is worth.' if own else ''}\n"
    )
    return "\n".join(["## Methods worth considering\n", which, *parts])


def answers(row: Row) -> str:
    """What a row's answers are, in words; near an optimum where only a solver's tolerance misses it."""
    title = find_formulation(row.formulation).title
    if not right(row):
        return f"wrong: {row.wrong or 'farther from the optimum than promised'}"
    if not optimal(row) or exact(row):
        return title
    return f"near {title}" if complete(row) else f"aims at {title}, misses some that can be met"


def _not_measured(run: Run, vehicle: str, demands: str) -> list[list[str]]:
    """A line for each method of the user's own that has no time on the demand set, with the reason."""
    failed = [row for row in run.of(vehicle, demands) if row.described.plugin and row.failed]
    return [[row.label, f"{row.status}: {row.reason}", *[""] * (len(HEADERS) - 2)] for row in failed]


def _line(run: Run, row: Row) -> list[str]:
    times = [three(row.call_p50_us), three(run.tail_us(row, 0.999))]
    return [row.label, answers(row), *times, lost(row), served(run, row.vehicle, row), three(row.peak_rss_MB)]
