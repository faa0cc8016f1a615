"""A run as reports see it: the record's cells gathered into rows, one a line of results.csv."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from statistics import median

from bench.record import Batch, Cell, Judged, Record, Worker, read

Counted = list[tuple[int, int]]
"""A multiset of times: [(ns, how often), …], sorted."""


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
    """A record and its rows."""

    record: Record
    rows: tuple[Row, ...]


def merged(counted: Iterable[Counted]) -> Counted:
    """Several multisets of times as one."""
    times: dict[int, int] = defaultdict(int)
    for ns, count in chain.from_iterable(counted):
        times[ns] += count
    return sorted(times.items())


def read_run(directory: Path) -> Run:
    """The run in a folder; raises RecordError where there is no readable record."""
    record = read(directory)
    return Run(record, gather(record))


def gather(record: Record) -> tuple[Row, ...]:
    """The record's cells as rows, sorted by vehicle, demand set, method, start and level."""
    repeats: dict[tuple[str, str, str, str, str], dict[int, Cell]] = defaultdict(dict)
    for cell in record.cells:
        k = cell.key
        repeats[k.vehicle, k.demands, k.method, k.start, k.level][k.repeat] = cell
    rows = []
    for key, cells in sorted(repeats.items()):
        at_work = tuple(w for w in record.workers if (w.method, w.start, w.level) == key[2:])
        rows.append(Row(*key, tuple(cells[r] for r in sorted(cells)), at_work))
    return tuple(rows)
