"""Tables of numbers as loggers write them: commas, semicolons, tabs or blanks, decimal commas, comments."""

import csv
import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from alloc.errors import FileError
from alloc.files.textfile import read_text
from bench.inputs.columns import VOLTS, Column, unit_of
from bench.inputs.csv_text import is_number
from bench.inputs.frames import frame_in
from bench.inputs.units import FORCE, MOMENT, SECONDS, TIME

UNITS = {*FORCE, *MOMENT, *SECONDS, "N m", "N·m", "N*m", "µs", "%"}
"""Units of which a line below the header holds at least one."""
TABLES = (".csv", ".txt", ".tsv", ".dat", "")
"""Suffixes of tables; a pipe, as in <(zcat demands.csv.gz), has none."""
COMMENT = ("#", "%", "//")
NAMES = {",": "commas", ";": "semicolons", "\t": "tabs", " ": "blanks"}
MARKS = {",": "comma", ".": "point"}
_TOLD = re.compile(r"sep=([,;\t])[ \r]*$", re.IGNORECASE | re.MULTILINE)
_ISO = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?", re.ASCII)


@dataclass
class Cells:
    """The cells of a file below its header.

    Attributes
    ----------
    path, line : the file, and the line of its header
    header : the cells of the header, without blanks around them
    units : the cells of a line of units below the header; empty where there is none
    separator : what stands between cells
    decimal : ``.`` or ``,`` once a number has shown which one the file has, else empty
    frame : what comments say, and which of them, as ``frame_in`` has it
    times : ``dates`` or ``numbers`` once a time has shown which ones the file has, else empty
    rows : the other rows, each with its line
    """

    path: Path
    line: int
    header: list[str]
    units: list[str]
    separator: str
    rows: Iterator[tuple[int, list[str]]] = field(repr=False)
    decimal: str = ""
    frame: tuple[str, str] = ("", "")
    times: str = ""

    def stamped(self, column: Column) -> Column:
        """The time's column, in seconds where its cells are dates, whatever resolution its name says.

        Raises FileError where these are numbers in a unit that is not known.
        """
        if (
            self.times != "dates"
            and column.factor is None
            and (unit := unit_of(column.name, self.units, column.place))
        ):
            raise self.refused(
                self.line,
                f"the unit of {column.name[:40]!r} is {unit[:40]!r}, none of {', '.join(SECONDS)}; convert it"
                " in the file, or leave it out of --columns",
            )
        return column._replace(factor=1.0) if self.times == "dates" else column

    def number(self, line: int, column: str, cell: str, most: float) -> float:
        """The number in a cell, no larger than ``most``, or of the time also seconds of a date.

        Raises FileError naming file, line and column.
        """
        text = cell.strip()
        since_1970 = _date(text) if column == TIME else None
        if column == TIME:
            kind = "numbers" if since_1970 is None else "dates"
            if self.times not in ("", kind):
                raise self.refused(
                    line, f"t is {text[:40]!r}; times above are {self.times}: write all of them alike"
                )
            self.times = kind
        if since_1970 is not None:
            return since_1970
        comma = self.separator != "," and bool(_DECIMAL_COMMA.fullmatch(text))
        mark = "," if comma else "." if "." in text else ""
        if mark and self.decimal and mark != self.decimal and ":" not in text:  # a clock is no number
            raise self.refused(
                line,
                f"{column} is {text[:40]!r}, with a decimal {MARKS[mark]}; numbers above have a decimal"
                f" {MARKS[self.decimal]}: write all of them alike",
            )
        self.decimal = self.decimal or mark
        if comma:
            text = text.replace(",", ".")
        if not is_number(text):
            other = ", a date as 2024-05-01T12:00:00.02, or t another name" if column == TIME else ""
            if column == VOLTS and is_blank([text]):
                other = "; use the previous row's voltage (for the first row, the next one's)"
            why = f"{column} is {text[:40]!r}; give a finite number such as -12.5 or 1e-5{other}"
            raise self.refused(line, why)
        value = float(text)
        if not abs(value) <= most:
            raise self.refused(line, f"{column} is {text[:40]!r}, too large; check its unit")
        return value

    def refused(self, line: int, why: str) -> FileError:
        """The error that names file and line."""
        return FileError(why, path=self.path, line=line)


def is_blank(cells: Iterable[str]) -> bool:
    """True if cells hold no number: they are empty, or NaN, which tools that merge logs fill in."""
    return all(cell.strip().lower() in ("", "nan") for cell in cells)


def read_table(path: Path) -> Cells:
    """The header of a file and an iterator over its rows; raises FileError where it is no such table.

    A first line ``sep=;``, as spreadsheets write it, says the separator. Lines that begin with ``#``, ``%``
    or ``//`` are comments, but for a line of units below the header. The last one is the header where the
    line below it has numbers, and is as long.
    """
    text = read_text(path)
    lines = list(io.StringIO(text, newline=""))
    if told := _TOLD.match(text):
        lines[0] = "\n"
    kept = ["\n" if line.lstrip().startswith(COMMENT) else line for line in lines]
    first = next((i for i, line in enumerate(kept) if line.strip()), None)
    if first is None:
        return Cells(path, 1, [], [], ",", iter(()))
    if lines[first + 1 :] and not kept[first + 1].strip():
        kept[first + 1] = _units_in(lines[first + 1], kept[first])
    below = next((line for line in kept[first + 1 :] if line.strip()), "")
    separator = told[1] if told else _separator(kept[first], below)
    if any(numeric(cell) for cell in _cells(kept[first], separator)):  # names are no numbers
        separator = _take_header(lines, kept, first) or separator
    if separator == " ":
        kept = [" ".join(line.split()) + "\n" for line in kept]
    rows = _rows(path, kept, separator)
    line, header = next(rows, (first + 1, []))
    units: list[str] = []
    ahead = next(rows, None)
    if ahead is not None and not any(map(numeric, ahead[1])):
        words = [_unit(cell) for cell in ahead[1]]
        if UNITS & set(words) and not {"nan", "inf"} & {word.lower().lstrip("+-") for word in words}:
            units, ahead = words, None
    named = [cell.strip() for cell in header]
    if ahead is not None and named[:1] == [""] and _date(ahead[1][0].strip()) is not None:
        named[0] = TIME  # as pandas writes an index of dates
    return Cells(path, line, named, units, separator, _chained(ahead, rows), frame=frame_in(text))


def _rows(path: Path, lines: list[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """The rows that are not blank, each with the line it ends on."""
    reader = csv.reader(iter(lines), delimiter=separator, strict=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                yield reader.line_num, row
    except csv.Error as error:
        raise FileError(f"not CSV ({error}); mend that line", path=path, line=reader.line_num) from None


def _chained(
    first: tuple[int, list[str]] | None, rest: Iterator[tuple[int, list[str]]]
) -> Iterator[tuple[int, list[str]]]:
    if first is not None:
        yield first
    yield from rest


def _separator(line: str, below: str) -> str:
    """Separator of the cells of a header; blanks only where the line below has as many of them."""
    for separator in (";", "\t", ","):
        if separator in line:
            return separator
    words = line.split()
    return " " if len(words) > 1 and len(words) == len(below.split()) else ","


def _take_header(lines: list[str], kept: list[str], first: int) -> str:
    """Put comments above rows of numbers, from ``first`` on, that are their header and units into ``kept``.

    Returns the header's separator, empty where no comment is as long as a row.
    """
    above = [i for i in reversed(range(first)) if lines[i].strip()]
    if len(above) > 1 and (units := _units_in(lines[above[0]], kept[first])).strip():
        kept[above.pop(0)] = units
    if not above:
        return ""
    header = _uncommented(lines[above[0]])
    mark = _separator(header, kept[first])
    if len(_cells(header, mark)) != len(_cells(kept[first], mark)):
        return ""
    kept[above[0]] = header
    return mark


def _uncommented(line: str) -> str:
    return line.lstrip().lstrip("#%/ ")


def _units_in(line: str, beside: str) -> str:
    """A line that says units, without a comment's mark before them; an empty line for any other.

    It has as many cells as the line beside it, none of them a number. Where the first cell is ``%`` alone,
    that is a unit, and no mark.
    """
    separator = _separator(beside, line)
    cells = _cells(line.strip(), separator)
    bare = line if cells and _unit(cells[0]) == "%" else _uncommented(line)
    words = [_unit(cell) for cell in _cells(bare.strip(), separator)]
    if len(words) != len(_cells(beside.strip(), separator)) or any(map(numeric, words)):
        return "\n"
    return bare if words[0] == "%" or UNITS & set(words) else "\n"


def _unit(cell: str) -> str:
    return cell.strip("[]() ")


def _cells(line: str, separator: str) -> list[str]:
    return line.split(None if separator == " " else separator)


def _date(text: str) -> float | None:
    """Seconds since 1970 of a date and time as ISO 8601 has them, UTC where it names no zone; else None."""
    if not _ISO.match(text):
        return None
    try:
        date = datetime.fromisoformat(text)
    except ValueError:
        return None
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def numeric(cell: str) -> bool:
    """True if a cell reads as a number, with a decimal point or a decimal comma."""
    return is_number(cell) or bool(_DECIMAL_COMMA.fullmatch(cell.strip()))
