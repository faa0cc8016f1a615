"""Report section: who agrees with whom, and what failed and why."""

from bench import columns
from bench.report.text import table
from bench.rows import Run


def section(run: Run) -> str:
    """Disagreements and wrong answers by name, then what could not be measured, each with its reason."""
    odd = [row for row in run.rows if columns.agrees(row) == "no" or columns.wrong(row)]
    failed = [row for row in run.rows if row.failed]
    parts = ["## Agreement and failures\n"]
    judged = sum(columns.agrees(row) == "yes" for row in run.rows)
    parts.append(f"{judged} rows agree with the optimum of their formulation; {len(odd)} do not.\n")
    if odd:
        cells = [[r.label, r.vehicle, r.demands, str(columns.wrong(r)) or "too far off"] for r in odd]
        parts.append(table(("method", "vehicle", "demands", "what is wrong"), cells))
    if failed:
        cells = [
            [r.label, r.vehicle, r.demands, str(columns.status(r)), str(columns.reason(r))] for r in failed
        ]
        parts.append(table(("not measured", "vehicle", "demands", "status", "reason"), cells))
    return "\n".join(parts)
