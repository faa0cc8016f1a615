"""Reads CSV text as rows with line numbers and cells as numbers, and writes rows as CSV text."""

import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from alloc.errors import FileError
from alloc.vehicle import LARGEST

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def csv_rows(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    """The rows of a CSV text that are not blank, each with the line it ends on; raises FileError."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                yield reader.line_num, row
    except csv.Error as error:
        raise FileError(f"{path}: line {reader.line_num}: not CSV ({error}); mend that line") from None


def number(path: Path, line: int, column: str, cell: str) -> float:
    """The number in a cell, no larger than any on a vehicle; raises FileError naming file, line, column."""
    text = cell.strip()
    if not _NUMBER.fullmatch(text):
        raise FileError(
            f"{path}: line {line}: {column} is {text[:40]!r}; give a finite number such as -12.5 or 1e-5"
        )
    value = float(text)
    if not abs(value) <= LARGEST:
        raise FileError(f"{path}: line {line}: {column} is {text[:40]!r}, too large; check its unit")
    return value


def is_number(cell: str) -> bool:
    """Whether a cell reads as a number."""
    return bool(_NUMBER.fullmatch(cell.strip()))


def csv_text(header: Sequence[str], rows: Iterable[Iterable[str | float]]) -> str:
    """A header and rows as CSV; numbers are the shortest that read back as the same double."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue()
