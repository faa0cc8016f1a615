"""Numbers in cells, and rows as CSV text."""

import csv
import io
import re
from collections.abc import Iterable, Sequence

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def is_number(cell: str) -> bool:
    """True if a cell reads as a number."""
    return bool(_NUMBER.fullmatch(cell.strip()))


def csv_text(header: Sequence[str], rows: Iterable[Iterable[str | float]]) -> str:
    """A header and rows as CSV; numbers are the shortest that read back as the same double."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue()
