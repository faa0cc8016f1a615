"""Report section: what a call of each method costs."""

from bench import columns
from bench.report.text import table, three
from bench.rows import Row, Run


def section(run: Run) -> str:
    """One table a vehicle: set-up, median and tail of each method and demand set."""
    timed = [row for row in run.rows if not row.failed and columns.call_p50_us(row) is not None]
    parts = ["## What a call costs\n"]
    for name in dict.fromkeys(row.vehicle for row in timed):
        parts += [f"### {name}\n", _vehicle([row for row in timed if row.vehicle == name])]
    return "\n".join(parts)


def _vehicle(rows: list[Row]) -> str:
    headers = ("method", "demands", "set-up [µs]", "median [µs]", "p99.9 [µs]", "max [µs]", "solver [µs]")
    times = (
        columns.setup_us,
        columns.call_p50_us,
        columns.call_p999_us,
        columns.call_max_us,
        columns.solver_p50_us,
    )
    return table(headers, [[row.label, row.demands, *(_number(time(row)) for time in times)] for row in rows])


def _number(value: columns.Value) -> str:
    return three(value) if isinstance(value, (int, float)) else ""
