"""results.csv: every row of a run through every column, and what the columns mean."""

import csv
import inspect
from collections.abc import Iterable
from pathlib import Path

from bench.results.columns import Row

BAR = "\\|"
"""A bar inside a cell of a Markdown table."""


def columns() -> dict[str, property]:
    """Every column by name, in the order in which ``bench.results.columns.Row`` defines them."""
    return {name: thing for name, thing in vars(Row).items() if isinstance(thing, property)}


def write_csv(rows: Iterable[Row], path: Path) -> None:
    """Write results.csv: a header of column names, one line a row, empty where nothing applies."""
    shown = columns()
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(shown)
        writer.writerows([_text(getattr(row, name)) for name in shown] for row in rows)


def documentation() -> str:
    """The columns as a Markdown table, from their docstrings."""
    meanings = {name: " ".join(inspect.cleandoc(c.__doc__ or "").split()) for name, c in columns().items()}
    lines = [f"| `{name}` | {text.replace('``', '`').replace('|', BAR)} |" for name, text in meanings.items()]
    return "\n".join(["| column | meaning |", "|---|---|", *lines, ""])


def _text(value: str | int | float | None) -> str:
    if not isinstance(value, float):
        return "" if value is None else str(value)
    # Six digits: more than a clock or a solver's tolerance can give. Always with a point, since readers
    # that guess a column's type from its first rows must not take 0 and 1 for whole numbers.
    text = f"{value:.6g}"
    return text if set(text) & set(".en") else f"{text}.0"
