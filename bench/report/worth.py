"""Report section: for each vehicle the few methods worth considering."""

from alloc import find_formulation
from bench.report.readme import lost, served
from bench.results.columns import Row
from bench.results.ranking import best, exact, optimal, worth_considering
from bench.results.rows import Run
from bench.results.text import table, three

HEADERS = ("method", "answers", "median [µs]", "p99.9 [µs]", "wrench lost, worst", "served", "memory [MB]")


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle: what no other method beats in time and loss, and what it is held against."""
    parts = []
    for vehicle in run.vehicles:
        demands = run.sets(vehicle)[0]
        rows = worth_considering(best(run, vehicle, demands))
        if rows:
            parts += [
                f"### {vehicle}, {demands} demands\n",
                table(HEADERS, [_line(run, row) for row in rows]),
            ]
    if not parts:
        return ""
    return "\n".join(
        [
            "## Methods worth considering\n",
            "What no other method beats in both time and loss, the fastest exact one in plain Python and by a"
            " solver, and the closed form and the rule of practice they are held against. *Served* is the"
            " share of what the vehicle can do that is delivered within 1 %; memory is of the process.\n",
            *parts,
        ]
    )


def answers(row: Row) -> str:
    """What a row's answers are, in words; near an optimum, where a solver's tolerance misses it."""
    title = find_formulation(row.formulation).title
    return f"near {title}" if optimal(row) and not exact(row) else title


def _line(run: Run, row: Row) -> list[str]:
    times = [three(row.call_p50_us), three(run.tail_us(row, 0.999))]
    return [row.label, answers(row), *times, lost(row), served(run, row.vehicle, row), three(row.peak_rss_MB)]
