"""The parent of a run: makes the questions, starts one worker after the other, keeps the record."""

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from pathlib import Path

import msgspec

from alloc import Entry, UnknownName, catalogue, find, load_plugin
from bench.harness import machine, quiet
from bench.harness.job import Job, Task
from bench.harness.plan import OVERHEAD_S, Group, Settings, budget_ns, check, groups
from bench.harness.process import work
from bench.judging.capability import measure_worths
from bench.judging.reference import problem, questions
from bench.record import SCHEMA, Cell, Event, Header, Key, Record, RecordError, Worker
from bench.record.writer import Writer
from bench.results.rows import GENERATED

HANGS = 3
"""Cells of one method that may reach the time limit; the rest of that method is then not tried."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C came while a run was measuring; its record holds what there is."""


@dataclass(frozen=True)
class Progress:
    """Where a run stands: cells done and in all, and the method that is measured now."""

    done: int
    total: int
    method: str


@dataclass
class Going:
    """A run under way.

    files: where each (vehicle, demand set) is stored. plugins: file of each method that is not the
    catalogue's. missing: what to install for the methods that need it. total: how many cells there
    will be. began, ready: when this go did so and its first cell could, on the monotonic clock [s].
    done: keys in the record. hung: keys, of any repeat, that reached the time limit. core: where
    workers are pinned. measured, timed_ns: cells of this go, sum of their timed calls.
    """

    settings: Settings
    writer: Writer
    files: dict[tuple[str, str], Path]
    plugins: dict[str, str]
    missing: dict[str, str]
    watch: Callable[[Progress], None]
    total: int
    began: float
    done: set[Key]
    hung: set[Key]
    core: int | None
    ready: float = field(default_factory=time.monotonic)
    measured: int = 0
    timed_ns: int = 0

    def keep(self, cell: Cell) -> None:
        """Append a cell to the record, and say so."""
        self.writer.append(cell)
        self.done.add(cell.key)
        self.measured += 1
        self.timed_ns += cell.timed_ns
        self.tell(cell.key.method)

    def tell(self, method: str) -> None:
        """Tell the watcher where the run stands."""
        self.watch(Progress(len(self.done), self.total, method))

    def wall_s(self) -> float:
        """How long this go has taken [s]."""
        return time.monotonic() - self.began

    def budget_ns(self) -> int:
        """What a next cell may take, so that the run ends when it should, on this machine as it is today."""
        untimed = time.monotonic() - self.ready - self.timed_ns / 1e9
        overhead = untimed / self.measured if self.measured else OVERHEAD_S
        left = self.settings.target_s - self.wall_s()
        return budget_ns(self.settings, left, self.total - len(self.done), overhead)

    def event(self, what: str) -> None:
        """Record that something happened to the run."""
        timed = round(self.timed_ns / 1e9, 3)
        self.writer.append(Event(what, _now(), round(self.wall_s(), 3), timed, quiet.load()))


def run(settings: Settings, directory: Path, *, resume: bool, watch: Callable[[Progress], None]) -> None:
    """Measure what the settings ask for into ``directory/record.jsonl``; tell ``watch`` where it stands.

    With ``resume``, cells that are in the record already are left as they are. Raises RecordError
    where the record can't be written or continued, and AllocError for unknown names. On Ctrl-C the
    worker is ended, the record says so, and Interrupted is raised.
    """
    began = time.monotonic()
    check(settings)
    entries, plugins = methods(settings)
    # Before the folder is touched: a name that is wrong leaves nothing behind.
    posed = questions(settings.vehicles, settings.demands, settings.faults, settings.seed, settings.n_demands)
    with Writer(directory) as writer, tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        header = make_header(settings)
        old = writer.resume() if resume else None
        if old is not None:
            check_same(old.header, header, writer.path)
        files = {}
        for i, question in enumerate(posed):
            files[question.vehicle.name, question.name] = Path(folder) / f"{i}.npz"
            question.save(Path(folder) / f"{i}.npz")
        if old is None:
            writer.create(header)
        known = old or Record(header)
        told = {(line.vehicle, line.demands) for line in known.problems}
        writer.extend(problem(q) for q in posed if (q.vehicle.name, q.name) not in told)
        valued = {worth.vehicle for worth in known.worths}
        writer.extend(measure_worths(own_vehicles(settings), settings.seed, valued))
        planned = groups(settings, entries, files)
        going = Going(
            settings=settings,
            writer=writer,
            files=files,
            plugins=plugins,
            missing={entry.name: entry.missing for entry in entries if entry.missing},
            watch=watch,
            total=sum(len(group.keys) for group in planned),
            began=began,
            done=known.keys(),
            hung={_any_repeat(cell.key) for cell in known.cells if cell.status == "timeout"},
            core=machine.core(),
        )
        going.event("began" if old is None else "resumed")
        try:
            with machine.set_aside():
                for group in planned:
                    measure(group, going)
        except KeyboardInterrupt:
            going.event("interrupted")
            raise Interrupted from None
        going.event("finished")


def measure(group: Group, going: Going) -> None:
    """Measure one group's keys that the record lacks, in as many processes as it takes."""
    pending = [key for key in group.keys if key not in going.done]
    hangs = 0
    while True:
        for excuse in [cell for key in pending if (cell := _excuse(key, hangs, going))]:
            pending.remove(excuse.key)
            going.keep(excuse)
        if not pending:
            return
        going.tell(group.method)
        before = len(pending)
        for line in work(_job(group, pending, going), going.settings.time_limit_s):
            if isinstance(line, Worker):
                going.writer.append(line)
            elif isinstance(line, Cell):
                pending.remove(line.key)
                going.keep(line)
                if line.status == "timeout":
                    hangs += 1
                    going.hung.add(_any_repeat(line.key))
        if len(pending) == before:  # a worker that ends without a word must not be started for ever
            going.keep(Cell(pending.pop(0), "crashed", reason="the worker ended without a result"))


def own_vehicles(settings: Settings) -> list[str]:
    """The settings' vehicles but for generated ones, whose worth says nothing to anybody."""
    return [name for name in settings.vehicles if not name.startswith(GENERATED)]


def methods(settings: Settings) -> tuple[list[Entry], dict[str, str]]:
    """The methods to measure, and the files of those that are plug-ins.

    A name may be a pattern as a shell has it, ``qp/*``. Raises UnknownName for one that nothing has, or that
    two have: they would share their rows.
    """
    plugged = {load_plugin(Path(path)): path for path in dict.fromkeys(settings.plugins)}
    wanted = settings.methods or (() if plugged else ("*",))
    for name in wanted:
        if not any(fnmatchcase(entry.name, name) for entry in catalogue()):
            find(name)  # raises UnknownName, which lists what there is
    found = [entry for entry in catalogue() if any(fnmatchcase(entry.name, name) for name in wanted)]
    for entry, path in plugged.items():
        if sum(entry.name == other.name for other in (*plugged, *found)) > 1:
            raise UnknownName(f"{path}: another method is called '{entry.name}' too; rename the file")
    return [*plugged, *found], {entry.name: path for entry, path in plugged.items()}


def make_header(settings: Settings) -> Header:
    """What ran where, with what."""
    return Header(
        schema=SCHEMA,
        started=_now(),
        commit=machine.commit(),
        seed=settings.seed,
        machine=machine.describe(),
        versions=machine.versions(),
        settings=msgspec.json.decode(msgspec.json.encode(settings)),  # as it will be read back
    )


def check_same(old: Header, new: Header, path: Path) -> None:
    """Raise RecordError unless a record with the old header can be continued under the new one."""
    facts = [
        {"commit": header.commit, **header.versions, **header.settings, **header.machine}
        for header in (old, new)
    ]
    for what in facts[0] | facts[1]:  # a package that came since is a difference too
        was, now = (found.get(what) for found in facts)
        if was != now:
            raise RecordError(f"{path}: was made with {what} {was!r}, this is {now!r}; give another --out")


def _excuse(key: Key, hangs: int, going: Going) -> Cell | None:
    # Why a cell is not even tried, as its row.
    if key.method in going.missing:
        return Cell(key, "missing", reason=going.missing[key.method])
    if hangs >= HANGS:
        return Cell(
            key, "timeout", reason=f"not tried: {hangs} other cells of this method reached the time limit"
        )
    if _any_repeat(key) in going.hung:
        return Cell(key, "timeout", reason="not tried: it reached the time limit in an earlier repeat")
    return None


def _any_repeat(key: Key) -> Key:
    return msgspec.structs.replace(key, repeat=0)


def _job(group: Group, keys: list[Key], going: Going) -> Job:
    somewhere = next(iter(going.files.values()))  # the canaries take any inputs
    tasks = [Task(key, str(going.files.get((key.vehicle, key.demands), somewhere))) for key in keys]
    return Job(
        method=group.method,
        start=group.start,
        level=group.level,
        repeat=group.repeat,
        tasks=tasks,
        plugin=going.plugins.get(group.method),
        budget_ns=going.budget_ns(),
        memory_bytes=going.settings.memory_MB << 20,
        core=going.core,
    )


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
