"""A run under way: what is done, what hung, how long is left."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from bench.harness import machine, quiet
from bench.harness.job import Job, MeasureTask, Task
from bench.harness.lines import now
from bench.harness.plan import OVERHEAD_S, Group, RunSettings, budget_ns
from bench.record import Cell, Event, Key
from bench.record.writer import Writer

HANGS = 3
"""Cells of one method that may reach the time limit; the rest of that method is then not tried."""


@dataclass(frozen=True)
class Progress:
    """Where a run stands: cells done and in all, and the method that is measured now."""

    done: int
    total: int
    method: str


@dataclass(kw_only=True)
class RunState:
    """A run since it was started, or resumed.

    Attributes
    ----------
    settings, writer, watch : what to do, where lines go, who is told
    began : when it was started or resumed, on the monotonic clock [s]
    ready : when its first cell could be measured, on the same clock [s]
    files : where the question of each (vehicle, demand set) is stored
    plugins : file of each method that is not the catalogue's
    missing : what to install, of the methods that need it
    total : how many cells there will be
    done : keys in the record
    hung : keys, of any repeat, that reached the time limit
    core : where workers are pinned
    measured, timed_ns : cells since it began, sum of their timed calls
    """

    settings: RunSettings
    writer: Writer
    watch: Callable[[Progress], None]
    began: float
    ready: float = 0.0
    files: dict[tuple[str, str], Path] = field(default_factory=dict)
    plugins: dict[str, str] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    total: int = 0
    done: set[Key] = field(default_factory=set)
    hung: set[Key] = field(default_factory=set)
    core: int | None = field(default_factory=machine.core)
    measured: int = 0
    timed_ns: int = 0

    def keep(self, cell: Cell) -> None:
        """Append a cell to the record, and say so."""
        self.writer.append(cell)
        self.done.add(cell.key)
        if cell.status == "timeout":
            self.hung.add(any_repeat(cell.key))
        self.measured += 1
        self.timed_ns += cell.timed_ns
        self.tell(cell.key.method)

    def tell(self, method: str) -> None:
        """Tell the watcher where the run stands."""
        self.watch(Progress(len(self.done), self.total, method))

    def event(self, what: str) -> None:
        """Record that something happened to the run."""
        self.writer.append(
            Event(
                what=what,
                at=now(),
                wall_s=round(time.monotonic() - self.began, 3),
                timed_s=round(self.timed_ns / 1e9, 3),
                load=quiet.load(),
            )
        )

    def excuse(self, key: Key, hangs: int) -> Cell | None:
        """The row of a cell that is not even tried, with the reason; None for one to be measured."""
        if key.method in self.missing:
            return Cell(key, "missing", reason=self.missing[key.method])
        if hangs >= HANGS:
            reason = f"not tried: {hangs} other cells of this method reached the time limit"
            return Cell(key, "timeout", reason=reason)
        if any_repeat(key) in self.hung:
            return Cell(key, "timeout", reason="not tried: it reached the time limit in an earlier repeat")
        return None

    def job(self, group: Group, keys: list[Key]) -> Job:
        """The job that measures these cells of a group."""
        somewhere = next(iter(self.files.values()))  # the canaries take any inputs
        tasks: list[Task] = [
            MeasureTask(key, str(self.files.get((key.vehicle, key.demands), somewhere))) for key in keys
        ]
        return msgspec.structs.replace(
            self.asking(),
            method=group.method,
            start=group.start,
            level=group.level,
            repeat=group.repeat,
            tasks=tasks,
            plugin=self.plugins.get(group.method),
            budget_ns=self._budget_ns(),
        )

    def asking(self) -> Job:
        """A job without a method or tasks, as every worker of this run starts."""
        return Job(method="", tasks=[], memory_bytes=self.settings.memory_MB << 20, core=self.core)

    def _budget_ns(self) -> int:
        # What a next cell may take, so that the run ends when it should, on this machine as it is today.
        untimed = time.monotonic() - self.ready - self.timed_ns / 1e9
        overhead = untimed / self.measured if self.measured else OVERHEAD_S
        left = self.settings.target_s - (time.monotonic() - self.began)
        return budget_ns(self.settings, left, self.total - len(self.done), overhead)


def any_repeat(key: Key) -> Key:
    """The key of the cell in its first repeat."""
    return msgspec.structs.replace(key, repeat=0)
