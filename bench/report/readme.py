"""The result table of README.md, between two marks."""

from collections import Counter
from pathlib import Path

from alloc import WRENCH_TOLERANCE, AllocError, Family, find_formulation
from alloc.formulations import EXACT_METHODS
from bench.record import RecordError
from bench.results.columns import Row
from bench.results.ranking import best, exact, largest_loss, optimal
from bench.results.rows import Run
from bench.results.text import percent, table, three

START, END = "<!-- results:start -->", "<!-- results:end -->"
VEHICLES = ("ukwial", "bluerov2-heavy")
"""The paper's vehicle, and the commonest one with eight thrusters. A run without them shows its first two."""
MOST: dict[str, int] = {Family.ONE_SHOT: 1, Family.SOFT: 1}
"""How many methods of a family are shown, the fastest ones; other families are shown whole."""


class MarkerError(AllocError):
    """A file has no marks for the table."""


def result_table(run: Run) -> str:
    """One line for each method: its median on each vehicle, and its tail and loss on the last vehicle.

    Raises RecordError for a run without times, such as one of emulated processors.
    """
    shown = [name for name in VEHICLES if name in run.vehicles] or run.vehicles[:2]
    if not shown:
        raise RecordError("this run holds no times of any vehicle, so no result table; give one that does")
    by_vehicle = {name: {row.method: row for row in best(run, name, run.sets(name)[0])} for name in shown}
    last = by_vehicle[shown[-1]]
    methods = dict.fromkeys(method for rows in reversed(by_vehicle.values()) for method in rows)
    count: Counter[str] = Counter()
    lines = []
    for method in methods:
        row = last.get(method) or next(rows[method] for rows in by_vehicle.values() if method in rows)
        kind = row.family
        count[kind] += 1
        if count[kind] <= MOST.get(kind, len(methods)):
            medians = [_median(rows.get(method)) for rows in by_vehicle.values()]
            lines.append(
                [
                    f"`{row.label}`",
                    _answers(row),
                    *medians,
                    *_tail(run, last.get(method)),
                    served(run, shown[-1], row),
                ]
            )
    headers = (
        "method",
        "answers",
        *(f"{name} [µs]" for name in shown),
        "p99.9 [µs]",
        "wrench lost, worst",
        "served",
    )
    return _caption(run, shown) + "\n" + table(headers, lines)


def served(run: Run, vehicle: str, row: Row) -> str:
    """The share of the vehicle's attainable set that a method delivers within 1 %; empty where not known.

    The share depends on the answers alone: a native build serves what its twin does, and any exact solver
    serves what ``nullspace`` does.
    """
    capability = run.capability(vehicle)
    served = [s for s in capability.served if s.fault is None] if capability else []
    shares = {s.method: s.within_1pct / s.n_demands for s in served}
    return percent(shares.get(EXACT_METHODS[0] if exact(row) else row.described.twin or row.method))


def put(path: Path, text: str, start: str = START, end: str = END) -> None:
    """Replace what stands between the two marks of a file; raises MarkerError."""
    try:
        whole = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise MarkerError(f"{path}: can't be read as text; give the README to update") from None
    before, opening, rest = whole.partition(start)
    _, closing, after = rest.partition(end)
    if not opening or not closing:
        raise MarkerError(f"{path}: has no '{start}' and '{end}'; write them where the table shall stand")
    path.write_text(f"{before}{start}\n{text}{end}{after}", encoding="utf-8")


def _caption(run: Run, shown: list[str]) -> str:
    machine, versions = run.record.header.machine, run.record.header.versions
    sets = ", ".join(sorted({run.sets(name)[0] for name in shown}))
    return (
        f"Median time of a call from Python, over batches of calls, on {sets} demands,"
        f" {machine.get('cpu', 'this machine')}, {versions.get('python', 'Python')}; of each method the"
        " fastest start and level that is right everywhere, exact ones before others. The last three columns"
        f" are {shown[-1]}'s: p99.9 of single calls on all its demand sets; *served* is the share of its"
        " attainable set that is delivered within 1 %.\n"
    )


def _answers(row: Row) -> str:
    title = find_formulation(row.formulation).title
    return f"near {title}" if optimal(row) and not exact(row) else title


def _median(row: Row | None) -> str:
    return three(row.call_p50_us) if row else ""


def _tail(run: Run, row: Row | None) -> tuple[str, str]:
    if row is None:
        return "", ""
    lost = largest_loss(row)
    met = lost is not None and lost < WRENCH_TOLERANCE
    return three(run.tail_us(row, 0.999)), "0" if met else percent(lost)
