"""CSV files from rows and columns, and the documentation of the columns of results.csv."""

import csv
import inspect
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TypeVar

from bench.results.columns import Row
from bench.results.text import table

R = TypeVar("R")
Value = str | int | float | None


def columns() -> dict[str, Callable[[Row], Value]]:
    """Every column of results.csv by name, in the order in which ``Row`` has them, then ``Judgements``."""
    members = (member for owner in Row.__mro__ for member in vars(owner).items())
    return {name: one.fget for name, one in members if isinstance(one, property) and one.fget}


def write_csv(
    path: Path, columns: Mapping[str, Callable[[R], Value]], rows: Iterable[R], *, pointed: bool = True
) -> None:
    """Write a header of column names and one line for each row, with None as an empty field.

    In text a control character is a blank, and what a spreadsheet would take for a formula begins with ``'``.
    Floats have six digits, more than a clock or a solver's tolerance can give. With ``pointed`` a float
    without decimals gets a point too, so that a reader that guesses a column's type from its first rows does
    not take it for an integer.
    """

    def text(value: Value) -> Value:
        if isinstance(value, str):
            return harmless(value)
        if not isinstance(value, float):
            return value
        digits = f"{value:.6g}"
        return digits if not pointed or set(digits) & set(".en") else f"{digits}.0"

    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([text(column(row)) for column in columns.values()] for row in rows)


def harmless(text: str) -> str:
    """The text as a spreadsheet shows it and no more: a name or a message may be made to be a formula."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return f"'{printable}" if printable[1:] and printable.lstrip()[:1] in ("=", "+", "-", "@") else printable


def documentation() -> str:
    """The columns as a Markdown table, from their docstrings."""
    meanings = {name: inspect.cleandoc(column.__doc__ or "") for name, column in columns().items()}
    return table(
        ("column", "meaning"),
        [(f"`{name}`", meaning.replace("``", "`")) for name, meaning in meanings.items()],
        markdown=True,
    )
