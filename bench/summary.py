"""What a run ends with on the terminal: a table, and what is wrong with which answers."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from bench.columns import agrees, call_p50_us, call_p99_us
from bench.rows import Row, read_run


def objections(rows: tuple[Row, ...]) -> list[str]:
    """One line for each row whose answers are wrong or disagree with the reference, naming it."""
    found = []
    for row in rows:
        place = f"{row.label} on {row.vehicle}, {row.demands} demands"
        for judged in row.judged:
            if judged.wrong:
                found.append(f"{place}: {judged.wrong}")
                break
            if judged.agrees is False:
                found.append(
                    f"{place}: {judged.distance_rel_max:.2g} of the largest limit away from the reference; "
                    f"it promises {judged.tolerance:.2g}"
                )
                break
    return found


def show(directory: Path, console: Console) -> bool:
    """Print the summary of the run in ``directory``; True where every answer is good."""
    rows = read_run(directory).rows
    table = Table("vehicle", "method", "demands", "p50 [us]", "p99 [us]", "agrees", "remark", box=None)
    for row in rows:
        failed = row.failed
        table.add_row(
            row.vehicle,
            row.label,
            row.demands,
            _number(call_p50_us(row)),
            _number(call_p99_us(row)),
            str(agrees(row)),
            f"{failed.status}: {failed.reason}" if failed else "",
        )
    console.print(table)
    wrong = objections(rows)
    for line in wrong:
        console.print(f"[red]{line}[/red]", highlight=False)
    return not wrong


def _number(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, (int, float)) else ""
