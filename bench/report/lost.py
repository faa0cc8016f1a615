"""Report section: what is lost without limits, or with a rule of thumb in their place."""

from bench import columns
from bench.ranking import best, number
from bench.report.text import percent, table, three
from bench.rows import Row, Run

NOTHING = 1e-6
"""A wrench delivered within this share of the demand is met: what SOLVED promises."""


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table a vehicle and demand set; methods that lose nothing share a line."""
    parts = [
        "## What you lose\n",
        "*Delivered* is the wrench that the thrusters push once each is clipped to its limits, whatever they"
        " were told. Shares are of the demanded wrench, lengths in units of what the vehicle can do on each"
        " axis.\n",
    ]
    for vehicle in run.vehicles:
        for demands in run.sets(vehicle):
            lines = _lines(best(run, vehicle, demands))
            if lines:
                parts += [f"### {vehicle}, {demands}\n", table(HEADERS, lines)]
    return "\n".join(parts) if len(parts) > 2 else ""


HEADERS = (
    "method",
    "median [µs]",
    "answers given",
    "wrench lost, median",
    "wrench lost, worst",
    "worst turn [°]",
    "within 1 %",
    "beyond limits",
    "effort over optimum, worst",
)


def _lines(rows: list[Row]) -> list[list[str]]:
    known = [row for row in rows if columns.lost_wrench_max(row) is not None]
    lossless = [row for row in known if _loses_nothing(row)]
    losing = [row for row in known if not _loses_nothing(row)]
    if not losing:
        return []
    lines = [[row.label, three(number(columns.call_p50_us(row))), *_numbers(row)] for row in losing]
    if lossless:
        names = ", ".join(row.label for row in lossless)
        lines.append([f"nothing lost: {names}", *[""] * (len(HEADERS) - 1)])
    return lines


def _loses_nothing(row: Row) -> bool:
    lost, beyond = number(columns.lost_wrench_max(row)), number(columns.limits_violated_share(row))
    answered = number(columns.answered_share(row))
    return lost is not None and lost <= NOTHING and not beyond and answered == 1.0


def _numbers(row: Row) -> list[str]:
    return [
        percent(number(columns.answered_share(row))),
        percent(number(columns.lost_wrench_p50(row))),
        percent(number(columns.lost_wrench_max(row))),
        three(number(columns.direction_error_max_deg(row))),
        percent(number(columns.within_1pct_share(row))),
        percent(number(columns.limits_violated_share(row))),
        percent(number(columns.effort_over_optimum_max(row))),
    ]
