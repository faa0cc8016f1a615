"""Tables of numbers in text files: header, units and rows, read by the standard library's csv."""

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from math import isnan
from pathlib import Path

from alloc.errors import FileError
from alloc.files.textfile import read_text
from bench.inputs.columns import SECONDS, TIME, UNITS, Column, TableHeader, columns_option

TABLES = (".csv", ".txt", ".tsv", ".dat", "")
"""Suffixes of tables; a pipe, as in <(zcat demands.csv.gz), has none."""
COMMENT = ("#", "%", "//")
LARGEST = 1e20
"""Bound on times, in any unit: a date in ns is 1.7e18."""
_MARK = re.compile(r"\s*(?:#|//|%(?!\s*(?:[,;\t%]|$)))+\s*")
"""Start of a comment line; a percent sign that is a cell of its own is a unit."""
_SEPARATOR = re.compile(r"sep=.[ \r]*$", re.IGNORECASE | re.MULTILINE)
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?", re.ASCII)
_ISO = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d", re.ASCII)


@dataclass
class Cells:
    """The cells of a file below its header.

    Attributes
    ----------
    path, line : the file, and the line of its header
    text : all of the file, comments included
    header : the cells of the header, without blanks around them
    units : the cells of a line of units below the header; empty where there is none
    separator : what stands between cells
    rows : the other rows, each with its line
    decimal : ``.`` or ``,`` once a number has shown which one the file has, else empty
    dates : whether times are dates, once one has shown it
    """

    path: Path
    line: int
    text: str
    header: list[str]
    units: list[str]
    separator: str
    rows: list[tuple[int, list[str]]]
    decimal: str = ""
    dates: bool | None = None

    @property
    def named(self) -> TableHeader:
        """The header with a unit for each column, and its place."""
        place = f"{self.path}, line {self.line}"
        return TableHeader(place, self.header, self.units or [""] * len(self.header))

    def error(self, line: int, why: str) -> FileError:
        """The error that names file and line."""
        return FileError(why, path=self.path, line=line)

    def checked_rows(self) -> Iterator[tuple[int, list[str]]]:
        """The rows; raises FileError for one with more or fewer cells than the header."""
        for line, row in self.rows:
            if len(row) != len(self.header):
                raise self.error(line, f"got {len(row)} cells, expected {len(self.header)}; mend the row")
            yield line, row

    def number(self, line: int, name: str, cell: str, most: float) -> float:
        """The number in a cell, at most ``most``; of a time also seconds since 1970 of a date.

        Raises FileError naming file, line and column.
        """
        text = cell.strip()
        if name == TIME:
            seconds = _seconds_of_date(text)
            if self.dates not in (None, seconds is not None):
                kinds = ("numbers", "dates")
                above = kinds[bool(self.dates)]
                raise self.error(line, f"t is {text[:40]!r}, expected {above} as above; write all alike")
            self.dates = seconds is not None
            if seconds is not None:
                return seconds
        comma = self.separator != "," and bool(_DECIMAL_COMMA.fullmatch(text))
        mark = "," if comma else "." if _NUMBER.fullmatch(text) and "." in text else ""
        if mark and self.decimal and mark != self.decimal:
            raise self.error(
                line,
                f"{name} is {text[:40]!r}, expected decimals {self.decimal!r} as above; write all alike",
            )
        self.decimal = self.decimal or mark
        text = text.replace(",", ".") if comma else text
        if not _NUMBER.fullmatch(text):
            date = ", or a date as 2024-05-01T12:00:00.02" if name == TIME else ""
            filled = "; use the previous row's (for the first row, the next one's)" if name == "volts" else ""
            raise self.error(
                line, f"{name} is {text[:40]!r}, expected a number such as -12.5 or 1e-5{date}{filled}"
            )
        value = float(text)
        if not abs(value) <= most:
            raise self.error(line, f"{name} is {text[:40]!r}, too large; check its unit")
        return value

    def time_factor(self, column: Column, given: Mapping[str, str]) -> float:
        """From a time column's numbers to s, 1 for dates; raises FileError where nothing states its unit."""
        if self.dates:
            return 1.0
        if isnan(column.factor):
            got = f"unit {column.unit[:40]!r}" if column.unit else "no unit"
            raise self.error(
                self.line,
                f"times {column.name[:40]!r} have {got}, expected one of {', '.join(SECONDS)};"
                f" {columns_option({**given, TIME: f'{column.name} [UNIT]'})}",
            )
        return column.factor


def is_number(cell: str) -> bool:
    """True if a cell reads as a number."""
    return bool(_NUMBER.fullmatch(cell.strip()))


def is_numeric(cell: str) -> bool:
    """True if a cell reads as a number, with a decimal point or a decimal comma."""
    return is_number(cell) or bool(_DECIMAL_COMMA.fullmatch(cell.strip()))


def is_blank(cells: Iterable[str]) -> bool:
    """True if cells hold no number: they are empty, or NaN, which tools that merge logs fill in."""
    return all(cell.strip().lower() in ("", "nan") for cell in cells)


def read_table(path: Path) -> Cells:
    """Read a table; raises FileError where it is none.

    Cells stand between semicolons, tabs, commas or blanks, whichever of these the header has first. Lines
    that begin with ``#``, ``%`` or ``//`` are comments, but for units below the header, and for the last
    one above rows of numbers where it is as long as these: then it is the header, as rostopic writes it.
    """
    text = read_text(path)
    lines = list(io.StringIO(text, newline=""))
    if _SEPARATOR.match(text):  # a spreadsheet's line ``sep=;``
        lines[0] = "\n"
    kept = ["\n" if line.lstrip().startswith(COMMENT) else line for line in lines]
    top = next((i for i, line in enumerate(kept) if line.strip()), None)
    if top is None:
        return Cells(path, 1, text, [], [], ",", [])
    separator = _separator(kept[top])
    cells = _cells(kept[top], separator)
    if any(map(is_numeric, cells)):
        bare = {i: _MARK.sub("", lines[i], count=1) for i in range(top) if lines[i].strip()}
        alike = [i for i in bare if len(_cells(bare[i], _separator(bare[i]))) == len(cells)]
        for i in alike[-2:] if alike and _units_in(bare[alike[-1]], separator, cells) else alike[-1:]:
            kept[i] = bare[i]
            separator = _separator(bare[i])
    elif (line := "".join(lines[top + 1 : top + 2])) and not kept[top + 1].strip():
        forms = [_MARK.sub("", line, count=1), line if line.lstrip().startswith("%") else ""]
        kept[top + 1] = next((form for form in forms if _units_in(form, separator, cells)), "\n")
    if separator == " ":
        kept = [" ".join(line.split()) + "\n" for line in kept]
    rows = list(_rows(path, kept, separator))
    at, named = rows.pop(0) if rows else (top + 1, [])
    header = [cell.strip() for cell in named]
    units = _units_in(kept[rows[0][0] - 1], separator, header) if rows else []
    if units:
        del rows[0]
    if rows and header[:1] == [""] and _seconds_of_date(rows[0][1][0].strip()) is not None:
        header[0] = TIME  # as pandas writes an index of dates
    return Cells(path, at, text, header, units, separator, rows)


def _rows(path: Path, lines: Sequence[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """The rows that are not blank, each with the line it ends on."""
    reader = csv.reader(iter(lines), delimiter=separator, strict=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                yield reader.line_num, row
    except csv.Error as error:
        raise FileError(f"not CSV ({error}); mend that line", path=path, line=reader.line_num) from None


def _separator(line: str) -> str:
    return next((mark for mark in (";", "\t", ",") if mark in line), " ")


def _cells(line: str, separator: str) -> list[str]:
    return line.split(None if separator == " " else separator)


def _units_in(line: str, separator: str, header: Sequence[str]) -> list[str]:
    """The units on a line, one a column and at least one of them known; empty for any other line."""
    words = [cell.strip().strip("[]() ") for cell in _cells(line.strip(), separator)]
    alike = len(words) == len(header) and not any(map(is_numeric, words))
    return words if alike and UNITS & set(words) else []


def _seconds_of_date(text: str) -> float | None:
    """Seconds since 1970 of a date and time as ISO 8601 has them, UTC where it names no zone; else None."""
    if not _ISO.match(text):
        return None
    try:
        date = datetime.fromisoformat(text)
    except ValueError:
        return None
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()
