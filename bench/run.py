"""The parent of a run: makes the questions, starts one worker after the other, keeps the record."""

import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import msgspec
import numpy as np

from alloc import Entry, Label, NotApplicable, Vehicle, catalogue, find, load_plugin, load_vehicle
from bench import machine, quiet
from bench.demands import build_demands
from bench.job import Job, Task
from bench.plan import Group, Settings, budget_ns, groups
from bench.process import work
from bench.record import SCHEMA, Cell, Event, Header, Key, Problem, RecordError, Worker, Writer
from bench.reference import Question, references

HANGS = 3
"""Cells of one method that may reach the time limit; the rest of that method is then not tried."""


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
    catalogue's. missing: what to install for the methods that need it. done: keys in the record.
    hung: cells without their repeat that reached the time limit. timed_ns: sum of timed calls.
    """

    settings: Settings
    writer: Writer
    files: dict[tuple[str, str], Path]
    plugins: dict[str, str]
    missing: dict[str, str]
    done: set[Key]
    watch: Callable[[str, int], None]
    budget_ns: int
    hung: set[Key] = field(default_factory=set)
    timed_ns: int = 0


def run(settings: Settings, directory: Path, *, resume: bool, watch: Callable[[Progress], None]) -> None:
    """Measure what the settings ask for into ``directory/record.jsonl``; tell ``watch`` where it stands.

    With ``resume``, cells that are in the record already are left as they are. Raises RecordError
    where the record can't be written or continued, and AllocError for unknown names. On Ctrl-C the
    worker is ended, the record says so, and KeyboardInterrupt goes on to the caller.
    """
    began = time.monotonic()
    entries, plugins = methods(settings)
    with Writer(directory) as writer, tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        header = make_header(settings)
        old = writer.resume() if resume else None
        if old is not None:
            check_same(old.header, header, writer.path)
        posed = questions(settings)
        files = {}
        for i, question in enumerate(posed):
            files[question.vehicle.name, question.name] = Path(folder) / f"{i}.npz"
            question.save(Path(folder) / f"{i}.npz")
        if old is None:
            writer.create(header)
            writer.extend(problem(question) for question in posed)
        planned = groups(settings, entries, files)
        total = sum(len(group.keys) for group in planned)
        going = Going(
            settings,
            writer,
            files,
            plugins,
            {entry.name: entry.missing for entry in entries if entry.missing},
            set() if old is None else old.keys(),
            lambda method, done: watch(Progress(done, total, method)),
            budget_ns(settings, planned),
        )
        writer.append(_event("began" if old is None else "resumed", began, going))
        try:
            for group in planned:
                measure(group, going)
        except KeyboardInterrupt:
            writer.append(_event("interrupted", began, going))
            raise
        writer.append(_event("finished", began, going))


def measure(group: Group, going: Going) -> None:
    """Measure one group's keys that the record lacks, in as many processes as it takes."""
    pending = [key for key in group.keys if key not in going.done]
    hangs = 0
    while pending:
        going.watch(group.method, len(going.done))
        excuse = _excuse(pending[0], hangs, going)
        if excuse is not None:
            cells: Iterable[object] = [excuse]
        else:
            cells = work(_job(group, pending, going), going.settings.time_limit_s)
        before = len(pending)
        for line in cells:
            if isinstance(line, Worker):
                going.writer.append(line)
            elif isinstance(line, Cell):
                going.writer.append(line)
                going.done.add(line.key)
                pending.remove(line.key)
                going.timed_ns += line.timed_ns
                going.watch(group.method, len(going.done))
                if line.status == "timeout":
                    hangs += 1
                    going.hung.add(msgspec.structs.replace(line.key, repeat=0))
        if len(pending) == before:  # a worker that ends without a word must not be started for ever
            lost = Cell(pending.pop(0), "crashed", reason="the worker ended without a result")
            going.writer.append(lost)
            going.done.add(lost.key)


def methods(settings: Settings) -> tuple[list[Entry], dict[str, str]]:
    """The methods to measure, and the files of those that are plug-ins; raises UnknownName."""
    plugged = {load_plugin(Path(path)): path for path in settings.plugins}
    if settings.methods:
        entries = [find(name) for name in settings.methods]
    else:
        entries = [] if plugged else list(catalogue())
    return [*plugged, *entries], {entry.name: path for entry, path in plugged.items()}


def questions(settings: Settings) -> list[Question]:
    """Every demand set of every vehicle, whole and with each fault, with its references.

    A set that a vehicle has no demands of (NotApplicable) is left out.
    """
    found: dict[tuple[str, str], Question] = {}
    for vehicle in [v for name in settings.vehicles for v in faulty(load_vehicle(name), settings.faults)]:
        for name in settings.demands:
            try:
                posed = build_demands(name, vehicle, settings.seed, settings.n_demands)
            except NotApplicable:
                continue
            optima, method = references(
                posed.vehicle, posed.taus, posed.labels == Label.INACTIVE, posed.alpha
            )
            found[posed.vehicle.name, posed.name] = Question(
                posed.name,
                posed.vehicle,
                posed.taus,
                posed.labels,
                posed.alpha,
                posed.rate_hz,
                optima,
                method,
            )
    if not found:
        raise NotApplicable("none of these vehicles has any of these demands; name others")
    return list(found.values())


def faulty(vehicle: Vehicle, faults: Iterable[str]) -> list[Vehicle]:
    """The vehicle with each fault: "" none, "3" thruster 3 off, "3@0.4" weakened, "each" every one off."""
    found: list[Vehicle] = []
    for fault in faults:
        thruster, _, readiness = fault.partition("@")
        if fault == "each":
            found += [vehicle.with_fault(i) for i in range(vehicle.n)]
        elif fault:
            found.append(vehicle.with_fault(int(thruster), float(readiness or 0)))
        else:
            found.append(vehicle)
    return found


def problem(question: Question) -> Problem:
    """What the record keeps of a question."""
    vehicle, names = question.vehicle, {label.value: label.name.lower() for label in Label}
    values, counts = np.unique(question.labels, return_counts=True)
    return Problem(
        vehicle=vehicle.name,
        demands=question.name,
        n_demands=len(question.taus),
        labels={names[int(value)]: int(count) for value, count in zip(values, counts, strict=True)},
        rate_hz=question.rate_hz,
        reference=question.reference,
        dof=list(vehicle.dof),
        n=vehicle.n,
        rank=vehicle.rank,
        nullity=vehicle.nullity,
        f_scale=vehicle.f_scale,
        wrench_scale=[float(scale) for scale in vehicle.wrench_scale],
    )


def make_header(settings: Settings) -> Header:
    """What ran where, with what."""
    return Header(
        schema=SCHEMA,
        started=_now(),
        commit=machine.commit(),
        seed=settings.seed,
        machine=machine.describe(),
        versions=machine.versions(),
        settings=msgspec.to_builtins(settings),
    )


def check_same(old: Header, new: Header, path: Path) -> None:
    """Raise RecordError unless a record with the old header can be continued under the new one."""
    facts = [
        {"commit": header.commit, **header.versions, **header.settings, **header.machine}
        for header in (old, new)
    ]
    for what, was in facts[0].items():
        now = facts[1].get(what)
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
    if msgspec.structs.replace(key, repeat=0) in going.hung:
        return Cell(key, "timeout", reason="not tried: it reached the time limit in an earlier repeat")
    return None


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
        budget_ns=going.budget_ns,
        memory_bytes=going.settings.memory_MB << 20,
        core=machine.cores()[0],
    )


def _event(what: str, began: float, going: Going) -> Event:
    wall = round(time.monotonic() - began, 3)
    return Event(what, _now(), wall, round(going.timed_ns / 1e9, 3), quiet.load())


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
