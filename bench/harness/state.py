"""State of a run: finished cells, cells that hung, the time that is left, and a progress bar of it."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from bench.harness import counters, machine
from bench.harness.lines import now
from bench.harness.plan import OVERHEAD_S, Group, RunSettings, budget_ns
from bench.harness.process import Job, MeasureTask, Task
from bench.record import Cell, Event, Key
from bench.record.file import Writer

HANGS = 3
"""After this many cells of one worker's method have reached the time limit, its other cells are not tried."""


@dataclass(frozen=True)
class Progress:
    """Progress of a run.

    Attributes
    ----------
    done, total : cells that are in the record, and cells that there will be
    method : what is measured now
    """

    done: int
    total: int
    method: str


@dataclass(kw_only=True)
class RunState:
    """A run since it was started, or resumed.

    Attributes
    ----------
    settings : what to measure
    writer : appends to the record
    watch : is called with the progress
    began : when the run was started or resumed, on the monotonic clock [s]
    ready : when the first cell could be measured, on the monotonic clock [s]
    files : (vehicle, demand set) to the file of its question
    sequences : (vehicle, demand set) of demands that follow each other in time
    plugins : method to the file of its plug-in, for methods that are not the catalogue's
    missing : method to what must be installed for it, for methods that lack something
    total : how many cells there will be
    done : keys of the cells in the record
    hung : keys of the cells that reached the time limit, in terms of the first repeat
    core : where workers are pinned, None for anywhere
    measured : cells since the run was started or resumed
    timed_ns : sum of their timed calls [ns]
    judging_ns : sum of their ``Cell.judging_ns``, which no budget of timed calls pays for [ns]
    """

    settings: RunSettings
    writer: Writer
    watch: Callable[[Progress], None]
    began: float
    ready: float = 0.0
    files: dict[tuple[str, str], Path] = field(default_factory=dict)
    sequences: set[tuple[str, str]] = field(default_factory=set)
    plugins: dict[str, str] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    total: int = 0
    done: set[Key] = field(default_factory=set)
    hung: set[Key] = field(default_factory=set)
    core: int | None = field(default_factory=machine.core)
    measured: int = 0
    timed_ns: int = 0
    judging_ns: int = 0

    def keep(self, cell: Cell) -> None:
        """Append a cell to the record and tell the watcher."""
        self.writer.append(cell)
        self.done.add(cell.key)
        if cell.status == "timeout":
            self.hung.add(any_repeat(cell.key))
        self.measured += 1
        self.timed_ns += cell.timed_ns
        self.judging_ns += cell.judging_ns
        self.tell(cell.key.method)

    def tell(self, method: str) -> None:
        """Tell the watcher how far the run has come, and which method is at work."""
        self.watch(Progress(done=len(self.done), total=self.total, method=method))

    def event(self, what: str) -> None:
        """Append an event to the record: began, resumed, interrupted or finished."""
        self.writer.append(
            Event(
                what=what,
                at=now(),
                wall_s=round(time.monotonic() - self.began, 3),
                timed_s=round(self.timed_ns / 1e9, 3),
                load=counters.load(),
            )
        )

    def excuse(self, key: Key, hangs: int) -> Cell | None:
        """A cell with the reason why it is not tried; None for a cell that is to be measured."""
        if key.method in self.missing:
            return Cell(key=key, status="missing", reason=self.missing[key.method])
        if hangs >= HANGS:
            reason = f"not tried: {hangs} other cells of this method reached the time limit"
            return Cell(key=key, status="timeout", reason=reason)
        if any_repeat(key) in self.hung:
            reason = "not tried: it reached the time limit in an earlier repeat"
            return Cell(key=key, status="timeout", reason=reason)
        return None

    def job(self, group: Group, keys: list[Key]) -> Job:
        """The job that measures these cells of a group."""
        somewhere = next(iter(self.files.values()))  # canaries have no demands, and are called with any
        tasks: list[Task] = [
            MeasureTask(key, str(self.files.get((key.vehicle, key.demands), somewhere))) for key in keys
        ]
        return msgspec.structs.replace(
            self.common_job(),
            method=group.method,
            start=group.start,
            level=group.level,
            repeat=group.repeat,
            tasks=tasks,
            plugin=self.plugins.get(group.method),
            budget_ns=self._budget_ns(),
        )

    def common_job(self) -> Job:
        """Job with all that the workers of this run have in common; method and tasks are empty."""
        return Job(method="", tasks=[], memory_bytes=self.settings.memory_MB << 20, core=self.core)

    def _budget_ns(self) -> int:
        # The overhead is what this run has measured so far, since it differs from machine to machine.
        judging = self.judging_ns / 1e9
        untimed = time.monotonic() - self.ready - self.timed_ns / 1e9 - judging
        overhead = untimed / self.measured if self.measured else OVERHEAD_S
        left = self.settings.target_s - (time.monotonic() - self.began) + judging
        return budget_ns(self.settings, left, self.total - len(self.done), overhead)


def any_repeat(key: Key) -> Key:
    """The key of the cell in its first repeat."""
    return msgspec.structs.replace(key, repeat=0)


@contextmanager
def bar(console: Console) -> Iterator[Callable[[Progress], None]]:
    """A bar on the console, and the function that moves it."""
    # A plug-in's name may hold brackets, which are no markup.
    name = TextColumn("{task.description}", markup=False)
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), name)
    # Four frames a second, on the parent's core: drawing must not disturb what is measured.
    with Bar(*columns, console=console, refresh_per_second=4) as shown:
        task = shown.add_task("making demands")

        def watch(now: Progress) -> None:
            shown.update(task, completed=now.done, total=now.total, description=now.method)

        yield watch
