"""What a run measures, and in which order: pure functions of its settings."""

import random
from collections.abc import Iterable
from fnmatch import fnmatchcase

import msgspec

from alloc import AllocError, Entry
from bench.harness.yardsticks import CANARIES, YARDSTICKS
from bench.record import Key

OVERHEAD_S = 0.03
"""What a cell takes besides its timed calls until a run knows its own: starting up, setting up, judging."""
LEAST_MS, MOST_MS = 15.0, 100.0
"""Bounds of a cell's budget: a handful of batches; what no statistic here gains from exceeding."""


class SettingsError(AllocError):
    """Settings contradict each other."""


class Settings(msgspec.Struct, frozen=True):
    """Everything that decides what a run measures; kept in the record's header.

    vehicles, methods, demands: names or paths; no methods: all. plugins: files with a method.
    faults: thrusters that are off, ``3``, or weakened, ``3@0.4``; "" is the whole vehicle.
    once: patterns of methods and demand sets that are measured in the first repeat only.
    starts, levels: which to take of those a method offers; empty: see ``chosen``.
    n_demands: of each set. budget_ms: timed calls of a cell in one repeat; None: whatever lets the
    whole run take about ``target_s``.
    time_limit_s: of a cell. memory_MB: of a worker.
    """

    vehicles: tuple[str, ...]
    demands: tuple[str, ...]
    methods: tuple[str, ...] = ()
    plugins: tuple[str, ...] = ()
    faults: tuple[str, ...] = ("",)
    once: tuple[str, ...] = ()
    starts: tuple[str, ...] = ()
    levels: tuple[str, ...] = ()
    repeats: int = 2
    seed: int = 0
    n_demands: int = 60
    budget_ms: float | None = None
    target_s: float = 155.0
    time_limit_s: float = 10.0
    memory_MB: int = 2048


class Group(msgspec.Struct, frozen=True):
    """What one worker process measures: a method with its start and level, once."""

    method: str
    start: str
    level: str
    repeat: int
    keys: tuple[Key, ...]


def groups(settings: Settings, entries: Iterable[Entry], asked: Iterable[tuple[str, str]]) -> list[Group]:
    """Every worker's keys, in order: repeat by repeat, shuffled within, so that drift hits all alike.

    ``asked`` are the (vehicle, demand set) pairs there are; the yardsticks come along by themselves.
    """
    pairs = list(asked)
    choices = [choice for entry in entries for choice in chosen(entry, settings)]
    choices += [(name, "-", "-") for name in YARDSTICKS]
    dice = random.Random(settings.seed)
    planned: list[Group] = []
    for repeat in range(settings.repeats):
        dice.shuffle(choices)
        for method, start, level in choices:
            places = [("-", "-")] if method in CANARIES else dice.sample(pairs, len(pairs))
            if repeat > 0:
                places = [place for place in places if not _once(settings, method, place[1])]
            keys = tuple(Key(*place, method, start, level, repeat) for place in places)
            if keys:
                planned.append(Group(method, start, level, repeat, keys))
    return planned


def _once(settings: Settings, method: str, demands: str) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in settings.once for name in (method, demands))


def chosen(entry: Entry, settings: Settings) -> list[tuple[str, str, str]]:
    """(method, start, level) for each start and level to measure.

    Unless told otherwise: one start, ``reused`` where it is offered, as that is how a vehicle would run
    it; of the hard QPs every level, which shows the price of accuracy; of others the most accurate one.
    """
    starts = settings.starts or (("reused",) if "reused" in entry.starts else entry.starts[:1])
    levels = settings.levels or (entry.levels if entry.name.startswith("qp/") else entry.levels[-1:])
    if len(entry.levels) == 1:  # an exact solver, or the one-shot route: there is nothing to choose
        levels = entry.levels
    return [
        (entry.name, start, level)
        for start in entry.starts
        for level in entry.levels
        if start in (*starts, "-") and level in levels
    ]


def check(settings: Settings) -> None:
    """Raise SettingsError where no cell can be measured: its timed calls alone outlast its time limit."""
    least_s = (settings.budget_ms or 0.0) / 1e3
    if least_s >= settings.time_limit_s:
        raise SettingsError(
            f"--budget-ms {settings.budget_ms:g}: no cell can be timed for so long within --time-limit"
            f" {settings.time_limit_s:g}; raise the limit"
        )


def budget_ns(settings: Settings, left_s: float, cells: int, overhead_s: float) -> int:
    """How long the timed calls of each next cell should take [ns], roughly; see ``Settings.budget_ms``.

    ``cells`` are to be measured in ``left_s`` seconds; each takes ``overhead_s`` besides its timed calls.
    """
    if settings.budget_ms is not None:
        return round(settings.budget_ms * 1e6)
    each_ms = 1e3 * (left_s / max(cells, 1) - overhead_s)
    return round(1e6 * min(max(each_ms, LEAST_MS), MOST_MS))
