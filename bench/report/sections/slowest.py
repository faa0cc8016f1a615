"""Report section: the demand of each slowest call, where a board said it."""

from bench.results.rows import Run
from bench.results.text import table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table of the slowest call of each method on each demand set, and what was asked in it."""
    lines = []
    for row in run.rows:
        known = [cell for cell in row.measured.cells if cell.worst and cell.singles]
        if known:
            slowest = max(known, key=lambda cell: cell.singles[-1][0])
            demand = ", ".join(three(value) for value in slowest.worst)
            lines.append([row.vehicle, row.demands, row.method, three(row.call_max_us), demand])
    if not lines:
        return ""
    headers = ("vehicle", "demands", "method", "slowest call [µs]", "its demand [N, N m]")
    return "\n".join(["## The slowest calls, and what was asked in them\n", table(headers, lines)])
