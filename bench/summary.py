"""What a run ends with on the terminal: one line a method, and what is wrong with which answers."""

from collections import Counter
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

from rich.console import Console
from rich.table import Table

from bench.columns import call_p50_us, call_p99_us, solved_fraction
from bench.rows import Row, read_run


def objections(rows: Iterable[Row]) -> list[str]:
    """One line for each row whose answers are wrong or disagree with the reference, naming it."""
    found = []
    for row in rows:
        judged = next((j for j in row.judged if j.wrong or j.agrees is False), None)
        if judged is None:
            continue
        what = judged.wrong or (
            f"{judged.distance_rel_max:.2g} of the largest limit away from the reference, "
            f"where {judged.tolerance:.2g} is promised"
        )
        found.append(f"{row.label} on {row.vehicle}, {row.demands} demands: {what}")
    return found


def show(directory: Path, console: Console) -> bool:
    """Print the summary of the run in ``directory``; True where every answer is good."""
    rows = sorted(read_run(directory).rows, key=lambda row: row.label)
    table = Table(box=None, caption="p50, p99: least … largest over vehicles and demand sets [us]")
    for heading in ("method", "p50", "p99", "solved", "agrees", "not measured"):
        table.add_column(heading, no_wrap=True)
    for label, same in groupby(rows, key=lambda row: row.label):
        table.add_row(label, *_method(list(same)))
    console.print(table)
    wrong = objections(rows)
    for line in wrong:
        console.print(line, style="red", highlight=False, markup=False, soft_wrap=True)
    return not wrong


def _method(rows: list[Row]) -> tuple[str, ...]:
    verdicts = [judged.agrees for row in rows for judged in row.judged if judged.agrees is not None]
    agreement = "-" if not verdicts else "yes" if all(verdicts) else f"no, {verdicts.count(False)} times"
    failures = Counter(row.failed.status for row in rows if row.failed)
    return (
        _range(map(call_p50_us, rows)),
        _range(map(call_p99_us, rows)),
        _range(map(solved_fraction, rows)),
        agreement,
        ", ".join(f"{count} {status}" for status, count in failures.items()),
    )


def _range(values: Iterable[object]) -> str:
    numbers = sorted(float(value) for value in values if isinstance(value, (int, float)))
    if not numbers:
        return ""
    low, high = f"{numbers[0]:.3g}", f"{numbers[-1]:.3g}"
    return low if low == high else f"{low} … {high}"
