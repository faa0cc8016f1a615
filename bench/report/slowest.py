"""Report section: the demand of each slowest call, where a board said it."""

from bench.results.rows import Run
from bench.results.text import table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table of the slowest call of each method on each demand set, and what was asked in it."""
    lines = []
    for row in run.rows:
        worst = next((cell.worst for cell in row.cells if cell.worst), None)
        if worst is not None:
            demand = ", ".join(three(value) for value in worst)
            lines.append([row.vehicle, row.demands, row.method, three(row.call_max_us), demand])
    if not lines:
        return ""
    headers = ("vehicle", "demands", "method", "slowest call [µs]", "its demand [N, N m]")
    return "\n".join(["## The slowest calls, and what was asked in them\n", table(headers, lines)])
