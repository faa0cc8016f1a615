"""Numbers and tables for readers: three significant digits, Markdown, CSV."""

import re
from collections.abc import Iterable, Sequence
from math import floor, isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tabulate import tabulate

from alloc.allocation import WRENCH_TOLERANCE
from alloc.vehicle.geometry import unit
from bench.results.quantiles import group

if TYPE_CHECKING:
    import pandas as pd


def three(value: float | None) -> str:
    """Three significant digits, without an exponent from 0.001 to a million; empty for None."""
    if value is None:
        return ""
    if value == 0:
        return "0"  # for -0.0 too, which would be shown as -0
    if not isfinite(value):
        return f"{value:g}"
    digits = 2 - floor(log10(abs(value)))
    rounded = round(value, digits)  # rounding may add a digit: 9.999 becomes 10.0
    digits = 2 - floor(log10(abs(rounded)))
    if not -4 <= digits <= 5:
        return f"{value:.2e}".replace("e-0", "e-").replace("e+0", "e")
    return f"{rounded:.{max(digits, 0)}f}"


def percent(share: float | None) -> str:
    """A share (0 to 1) in per cent, three significant digits; empty for None."""
    return "" if share is None else f"{three(100 * share)} %"


RARE = 10.0
"""Number of n draws that a share RARE / n of a set has in the mean: that all n miss it has a chance of
exp(-RARE), 0.005 %."""


def rarity(n: int) -> str:
    """Share of a set that may be worse than the worst of n drawn from it: ``less than 0.5 %``."""
    share = f"{100 * min(RARE / n, 1.0):.2g}"
    return f"less than {float(share):g} %"


def number_range(values: Iterable[float | None], to: str = " to ") -> str:
    """``1.20`` or ``1.20 to 3.40``: least and largest of the values that are not None, empty without any."""
    known = [value for value in values if value is not None]
    if not known:
        return ""
    low, high = three(min(known)), three(max(known))
    return low if low == high else f"{low}{to}{high}"


def plural(n: int, what: str) -> str:
    """``1 cell``, ``20 cells``."""
    return f"{n} {what}{'' if n == 1 else 's'}"


def table(headers: Sequence[str], rows: Iterable[Sequence[str]], *, markdown: bool = False) -> str:
    """A Markdown table that also reads well in a terminal: first column left, numbers right.

    Cells are text, not Markdown, but for those that are code from end to end; or all are, with ``markdown``.
    """
    headers = [_cell(text) for text in headers]
    cell = _escape_bars if markdown else _cell
    body = [[cell(text) for text in row] for row in rows]
    align = ["left", *("left" if _is_wordy(body, i) else "right" for i in range(1, len(headers)))]
    return tabulate(body, headers=headers, tablefmt="pipe", colalign=align, disable_numparse=True) + "\n"


def merge_lines(lines: Iterable[tuple[str, Iterable[str]]]) -> list[list[str]]:
    """Lines (name, cells) of a table, where names with equal cells share the line of the first."""
    alike = group(((name, tuple(cells)) for name, cells in lines), lambda line: line[1])
    return [[", ".join(name for name, _ in same), *cells] for cells, same in alike.items()]


def wrench_text(dof: Iterable[str], wrench: Iterable[float]) -> str:
    """``surge 10.0 N, yaw 2.00 N m``: a wrench by its axes."""
    return ", ".join(f"{axis} {three(value)} {unit(axis)}" for axis, value in zip(dof, wrench, strict=True))


def drop_rounding(value: float | None, rounding: float = WRENCH_TOLERANCE) -> float | None:
    """The value, or 0 where it is no larger than rounding: a wrench that errs by less counts as met."""
    return 0.0 if value is not None and abs(value) <= rounding else value


def plain(text: str) -> str:
    """Markdown that shows the text as it is, on one line: a user's name or message may hold anything."""
    return re.sub(r"^(?:(?=[#>+*=~-])|(\d+)(?=[.)]))", r"\1\\", _inline(text))


def with_code(text: str) -> str:
    """The same of a sentence of our own, in which what stands between backquotes is code."""
    parts = re.split(r"(`[^`]+`)", _printable(text))
    return "".join(part if i % 2 else _escape(part) for i, part in enumerate(parts))


def _inline(text: str) -> str:
    """The same where a line does not begin with it."""
    return _escape(_printable(text))


def _printable(text: str) -> str:
    """Printable part of a text, on one line."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _escape(shown: str) -> str:
    paired = "".join(mark for mark in "*$~" if shown.count(mark) > 1)  # a single one is itself
    return re.sub(rf"[{re.escape(paired)}]|{_MEANS}" if paired else _MEANS, r"\\\g<0>", shown)


_MEANS = r"[\\`|]|\](?=[(\[:])|<(?=[A-Za-z/!?])|&(?=#?\w+;)|(?<!\w)_|_(?!\w)"
"""Text that is Markdown wherever it stands: code, the middle of a link, a tag, an entity, emphasis."""


def _cell(text: str) -> str:
    return _escape_bars(text) if re.fullmatch(r"`[^`\n]+`", text) else _inline(text)


def _escape_bars(text: str) -> str:
    """Markdown on one line, its bars escaped."""
    return " ".join(text.split()).replace("|", "\\|")


def _is_wordy(body: list[list[str]], i: int) -> bool:
    return any(not row[i].lstrip("+-")[:1].isdigit() for row in body if row[i].strip("-–"))


def cut_note(log: str, asked: int, left_out: int) -> str:
    """A sentence on a log that was not asked whole."""
    return f"Of {log}'s {asked + left_out} demands only the first {asked} were asked; `--n` asks more."


def write_csv(path: Path, frame: "pd.DataFrame", *, pointed: bool = True) -> None:
    """Write a frame with its header; what is None, or no number, is an empty field.

    In text a control character is a blank, and what a spreadsheet would take for a formula begins with ``'``.
    Floats have six digits, more than a clock or a solver's tolerance can give. With ``pointed`` a float
    without decimals gets a point too, so that a reader that guesses a column's type from its first rows does
    not take it for an integer.
    """
    import pandas as pd

    def text(value: Any) -> str:
        if isinstance(value, str):
            return harmless(value)
        if pd.isna(value):
            return ""
        if not isinstance(value, float):
            return str(value)
        digits = f"{value:.6g}"
        return digits if not pointed or set(digits) & set(".en") else f"{digits}.0"

    frame.map(text).to_csv(path, index=False, lineterminator="\n")


def harmless(text: str) -> str:
    """The text as a spreadsheet shows it and no more: a name or a message may be made to be a formula."""
    printable = "".join(c if c.isprintable() else " " for c in text)
    return f"'{printable}" if printable[1:] and printable.lstrip()[:1] in ("=", "+", "-", "@") else printable
