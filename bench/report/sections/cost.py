"""Report section: what a call of each method costs."""

from alloc.formulations import list_formulations
from bench.report.pictures import picture
from bench.results.columns import Row
from bench.results.rows import Run
from bench.results.text import plain, table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle: set-up, median on each demand set, tail, and the solver's part of it."""
    answered = {row.formulation for row in run.rows}
    meanings = [f"*{f.name}* {f.meaning}" for f in list_formulations() if f.name in answered]
    caller = "the board's driver" if run.by_driver else "Python"
    parts = [
        "## What a call costs\n",
        f"Medians of one call from {caller} on each demand set; p99.9 of single calls on all sets together."
        " *Binding* is the solver's own Python call inside it, *own clock* what the solver reports of itself;"
        " the rest is posing the problem and checking the answer. A start is *cold* (new solver object each"
        " call), *reused* (same object) or *warm* (last answer as first guess). *Answers* names the question:"
        f" {'; '.join([*meanings, 'other names are rules of practice'])}.\n",
    ]
    for vehicle in run.vehicles:
        parts.append(f"### {plain(vehicle)}\n")
        for kind, alt in (
            ("cost", "median, p99.9 and slowest call by method"),
            ("pareto", "wrench lost over time by method"),
            ("period", "share of the control period at 50, 100 and 400 Hz"),
        ):
            parts.append(picture(f"{kind}-{vehicle}.svg", f"{vehicle}: {alt}", drawn))
        parts.append(_table(run, vehicle))
    return "\n".join(part for part in parts if part) if run.vehicles else ""


def _table(run: Run, vehicle: str) -> str:
    sets = run.sets(vehicle)
    variants: dict[str, dict[str, Row]] = {}
    for row in run.of(vehicle):
        if not row.failed and row.call_p50_us is not None:
            variants.setdefault(row.label, {})[row.demands] = row
    pinv = variants.get("pinv", {}).get(sets[0])
    base = pinv.call_p50_us if pinv else None
    lines = []
    for label, by_set in variants.items():
        first = by_set.get(sets[0]) or next(iter(by_set.values()))
        time = first.call_p50_us
        ratio = time / base if time is not None and base and first.demands == sets[0] else None
        medians = [three(_median(by_set.get(name))) for name in sets]
        inside = [three(first.binding_p50_us), three(first.solver_p50_us)]
        tail = three(run.tail_us(first, 0.999))
        setup = three(first.setup_us)
        answers = first.formulation or "-"
        lines.append((time or 0.0, [label, answers, setup, *medians, tail, three(ratio), *inside]))
    headers = ("method", "answers", "set-up [µs]", *(f"{name} [µs]" for name in sets), "p99.9 [µs]")
    ordered = [cells for _, cells in sorted(lines, key=lambda line: line[0])]
    return table((*headers, "over pinv", "binding [µs]", "own clock [µs]"), ordered)


def _median(row: Row | None) -> float | None:
    return None if row is None else row.call_p50_us
