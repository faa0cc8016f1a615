"""Report section: how late a call can be."""

from collections.abc import Iterable

from bench.record import NO_VEHICLE
from bench.record.cell import BIN
from bench.report.pictures import picture
from bench.results.columns import Row
from bench.results.quantiles import interval
from bench.results.ranking import best
from bench.results.rows import Run
from bench.results.text import plain, table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """Quantiles of single calls with their intervals, the slowest call, and the method's own worst case."""
    parts = [
        "## Tails\n",
        "Quantiles of single calls with 95 % intervals, given only where ten calls lie beyond them. The"
        " slowest call belongs to the machine as much as to the method; *iterations* and *steps* belong to"
        " the method alone (steps: a bound known before the first call).\n",
        _between_processes(run),
    ]
    canaries = [row for row in run.rows if row.vehicle == NO_VEHICLE and row.measured.singles]
    if canaries:
        parts += ["What this machine does to fixed work, in the same run:\n", _table(canaries)]
    for vehicle, demands in ((name, each) for name in run.vehicles for each in run.leading(name)):
        rows = [row for row in best(run, vehicle, demands) if row.measured.singles]
        if rows:
            alt = f"{vehicle}: share of calls slower than a time, by method"
            parts += [
                f"### {plain(vehicle)}, {plain(demands)}\n",
                picture(f"tails-{vehicle}.svg", alt, drawn) if demands == run.sets(vehicle)[0] else "",
                _table(rows),
            ]
    return "\n".join(part for part in parts if part) if len(parts) > 3 else ""


def unmet(rows: Iterable[Row]) -> tuple[int, int]:
    """Number of rows whose repeats' intervals of p99 do not all meet, of how many with two or more."""
    by_row = [[ends for cell in row.measured.cells if (ends := interval(cell.singles, 0.99))] for row in rows]
    several = [intervals for intervals in by_row if len(intervals) > 1]
    gaps = [max(low for low, _ in ends) / min(high for _, high in ends) for ends in several]
    return sum(gap > BIN for gap in gaps), len(gaps)  # the end of an interval is known to one bin


def _between_processes(run: Run) -> str:
    apart, several = unmet(run.rows)
    if not several:
        return ""
    return (
        "The intervals are what chance leaves open among these calls, as if each were independent of the one"
        " before. Another process, some time later, adds more: in"
        f" {apart} of {several} rows where two repeats have such an interval of p99, these do not meet.\n"
    )


def _table(rows: list[Row]) -> str:
    headers = ("method", "calls", "p99 [µs]", "p99.9 [µs]", "slowest [µs]", "iterations", "steps, at most")
    lines = []
    for row in rows:
        p99 = (row.call_p99_us, row.call_p99_low_us, row.call_p99_high_us)
        p999 = (row.call_p999_us, row.call_p999_low_us, row.call_p999_high_us)
        counts = [str(v or "") for v in (row.iterations_max, row.worst_case_steps)]
        slowest = three(row.call_max_us)
        calls = str(row.n_single_calls)
        lines.append([row.label, calls, _with_interval(p99), _with_interval(p999), slowest, *counts])
    return table(headers, lines)


def _with_interval(values: tuple[float | None, float | None, float | None]) -> str:
    middle, low, high = (three(value) for value in values)
    return f"{middle} ({low} … {high})" if middle else ""
