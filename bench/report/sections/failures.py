"""Report section: which answers agree with the optimum, which are wrong, and what was not measured."""

from collections import defaultdict
from operator import attrgetter

from bench.results.columns import Row
from bench.results.quantiles import largest
from bench.results.ranking import has_wrong_answer, objection
from bench.results.rows import Run
from bench.results.text import table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """How far each method is from the optimum, wrong answers by name, and what was not measured."""
    parts = [
        "## Agreement and failures\n",
        "Every timed answer is judged from T, H, limits and demand alone; a solver's status is not believed."
        " Distances are to the optimum of the same formulation, over the largest thrust limit"
        f"{'; where they matter, less what rounding of a demand explains' if run.by_driver else ''}.\n",
        _agreement([row for row in run.rows if not row.failed]),
        _wrong([row for row in run.rows if has_wrong_answer(row)]),
        _unmeasured([row for row in run.rows if row.failed]),
    ]
    return "\n".join(part for part in parts if part)


def _agreement(rows: list[Row]) -> str:
    by_label: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        if row.agreed is not None:
            by_label[row.label].append(row)
    lines = []
    for label, group in sorted(by_label.items()):
        agreeing = sum(row.agreed is True for row in group)
        distance, promise, gap = (
            largest(map(attrgetter(name), group))
            for name in ("distance_relative", "tolerance", "gap_relative")
        )
        answers = group[0].formulation
        lines.append(
            [label, answers, f"{agreeing} of {len(group)}", three(distance), three(promise), three(gap)]
        )
    headers = ("method", "answers", "rows that agree", "largest distance", "promised", "largest duality gap")
    return table(headers, lines) if lines else ""


def _wrong(rows: list[Row]) -> str:
    if not rows:
        return "No row disagrees, and no answer is wrong.\n"
    where: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    for row in rows:
        where[row.label, row.demands, objection(row)].append(f"{row.vehicle} ({_distance(row)})")
    lines = [[*key[:2], ", ".join(sorted(places)), key[2]] for key, places in sorted(where.items())]
    headers = ("method", "demands", "vehicle (distance found, promised)", "what is wrong")
    return "### Wrong\n\n" + table(headers, lines)


def _distance(row: Row) -> str:
    return f"{three(row.distance_relative) or '-'}, {three(row.tolerance) or '-'}"


def _unmeasured(rows: list[Row]) -> str:
    if not rows:
        return "No row is without a measurement.\n"
    where: dict[tuple[str, str, str], dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    absent = [row for row in rows if row.status == "missing"]
    for row in rows:
        if row.status != "missing":
            where[row.label, row.status, row.reason][row.vehicle].append(row.demands)
    lines = [
        [
            label,
            "; ".join(f"{vehicle}: {', '.join(sets)}" for vehicle, sets in places.items()),
            status,
            reason,
        ]
        for (label, status, reason), places in where.items()
    ]
    if absent:  # how to get each; one line says it for all
        methods = ", ".join(dict.fromkeys(row.method for row in absent))
        lines.append(
            [methods, "everywhere", "missing", "; ".join(dict.fromkeys(row.reason for row in absent))]
        )
    return "### Not measured\n\n" + table(("method", "where", "status", "reason"), lines)
