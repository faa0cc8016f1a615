"""A run as reports see it: the record's cells gathered into rows, one a line of results.csv."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from statistics import median

import msgspec

from alloc.errors import AllocError
from bench.record import SCHEMA, Batch, Cell, Header, Judged, Line, Worker

Counted = list[tuple[int, int]]
"""A multiset of times: [(ns, how often), …], sorted."""


class RecordError(AllocError):
    """A folder holds no record that this version can read."""


@dataclass(frozen=True)
class Row:
    """One method with its start and level on one vehicle's demand set: every repeat of it.

    Attributes
    ----------
    cells : the repeats, each measured by a process of its own
    workers : those processes
    """

    vehicle: str
    demands: str
    method: str
    start: str
    level: str
    cells: tuple[Cell, ...]
    workers: tuple[Worker, ...]

    @property
    def label(self) -> str:
        """Method, start and level as tables show them, e.g. ``qp/osqp warm tight``."""
        return " ".join([self.method, *(word for word in (self.start, self.level) if word not in ("", "-"))])

    @cached_property
    def failed(self) -> Cell | None:
        """The first repeat that was not measured, None where all were."""
        return next((cell for cell in self.cells if cell.status != "ok"), None)

    @cached_property
    def singles(self) -> Counted:
        """Times of single calls of all repeats together [ns]."""
        return merged(cell.singles for cell in self.cells)

    @cached_property
    def judged(self) -> list[Judged]:
        """What the equations say, one entry a repeat that was judged."""
        return [cell.judged for cell in self.cells if cell.judged is not None]

    def centre(self, batches: Callable[[Cell], Sequence[Batch]], clock: str = "wall_ns") -> list[float]:
        """Median time of a call [ns] over the batches of each repeat, one number a repeat."""
        timed = [batches(cell) for cell in self.cells]
        return [median(getattr(b, clock) / b.calls for b in repeat) for repeat in timed if repeat]

    def worst(self, what: Callable[[Judged], float | None]) -> float | None:
        """The largest value of ``what`` over the repeats, None where nobody has one."""
        return max((value for j in self.judged if (value := what(j)) is not None), default=None)


@dataclass(frozen=True)
class Run:
    """Everything one record holds."""

    header: Header
    rows: tuple[Row, ...]
    workers: tuple[Worker, ...]


def merged(counted: Iterable[Counted]) -> Counted:
    """Several multisets of times as one."""
    times: dict[int, int] = defaultdict(int)
    for ns, count in chain.from_iterable(counted):
        times[ns] += count
    return sorted(times.items())


def read_run(directory: Path) -> Run:
    """The run in a folder; raises RecordError naming file and remedy."""
    lines = _read(directory / "record.jsonl")
    header = lines[0]
    if not isinstance(header, Header):
        raise RecordError(f"{directory / 'record.jsonl'}: line 1 is no header; give a folder that a run made")
    workers = tuple(line for line in lines if isinstance(line, Worker))
    repeats: dict[tuple[str, str, str, str, str], dict[int, Cell]] = defaultdict(dict)
    for cell in lines:
        if isinstance(cell, Cell):
            k = cell.key
            repeats[k.vehicle, k.demands, k.method, k.start, k.level][k.repeat] = cell
    rows = []
    for key, cells in sorted(repeats.items()):
        at_work = tuple(w for w in workers if w.method == key[2] and w.repeat in cells)
        rows.append(Row(*key, tuple(cells[r] for r in sorted(cells)), at_work))
    return Run(header, tuple(rows), workers)


def _read(path: Path) -> list[Line]:
    try:
        texts = path.read_bytes().splitlines(keepends=True)
    except OSError as error:
        raise RecordError(
            f"{path}: can't be read ({error.strerror}); give a folder that a run made"
        ) from None
    # A run that was killed may leave half a line at the end.
    texts = [text for text in texts if text.strip() and text.endswith(b"\n")]
    lines: list[Line] = []
    for number, text in enumerate(texts, start=1):
        try:
            lines.append(msgspec.json.decode(text, type=Line))
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            raise RecordError(f"{path}: line {number}: not a record ({error}); run again") from None
    if not lines:
        raise RecordError(f"{path}: holds no complete line; run again")
    if isinstance(lines[0], Header) and lines[0].schema != SCHEMA:
        raise RecordError(f"{path}: schema {lines[0].schema}, this version reads {SCHEMA}; run again")
    return lines
