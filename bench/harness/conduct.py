"""Conduct of somebody's allocator beyond its answers: memory, threads, processes, output, state.

Looked at is this process, in which a library runs, and those that it has started, of which a program is one.
"""

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import psutil

from alloc import Allocation, Allocator
from bench.demands import DemandSet
from bench.harness.timing import Columns

LEAK_NS, LEAK_CALLS = 50_000_000, 100_000
"""Calls that memory is watched over: for so long, and so many at most."""
LEAK_BYTES = 1 << 20
"""Growth that is told [bytes]: what the C library keeps for later is less."""
MANY = 128
"""Demands that are asked together, at least: as many as a library is given at once, twice."""
MISSTATED = 1e-5
"""Largest error of a stated residual, relative to ``wrench_scale`` [-]: what single precision makes of it."""
LIMITED = 3
"""Arguments of a call with limits."""
SHOWN = 40
"""Characters of a library's output that a reason repeats."""


def misconduct(
    allocator: Allocator,
    inputs: Columns,
    answers: Sequence[Allocation],
    demands: DemandSet,
) -> list[str]:
    """Reasons why an allocator is not fit to fly, each in words; empty for one that only answers.

    ``answers`` are those to ``inputs``, of these demands in order. Each is asked once more, the last one
    first, and many together: an answer must be the same to the bit, whatever was asked before.
    """
    supply = demands.supply.arguments
    calls, call = list(zip(*inputs, strict=True)), partial(allocator, **supply)
    again: list[Allocation] = []
    misstated = together = ""
    with _captured() as output:
        for number in reversed(range(len(calls))):
            again.append(call(*calls[number]))
            misstated = misstated or _misstated(allocator, demands, number, again[-1])
        if not supply and len(inputs) <= LIMITED:  # many at once get no more than demands and limits
            together = _together(allocator, inputs, answers[: len(calls)])
    again.reverse()
    found = [_dependence(answers[: len(calls)], again) or together, misstated, _growth(call, calls)]
    if output:
        found.append(f"prints on standard output: {output[0][:SHOWN]!r}")
    return list(filter(None, found))


class Census(NamedTuple):
    """Count of what this process has started.

    Attributes
    ----------
    threads : its own and those of the processes, but for the first of each
    processes : that are there, ended ones and those that they have started too
    """

    threads: int
    processes: int


def take_census() -> Census:
    """Threads and processes now."""
    family = _family()
    return Census(sum(_each(family, psutil.Process.num_threads)) - len(family), len(family) - 1)


def leftovers(before: Census, after: Census) -> list[str]:
    """Threads and processes that calls between two counts left behind, in words."""
    more = zip(Census._fields, before, after, strict=True)
    return [f"its calls leave {what} behind: {b - a} more than before" for what, a, b in more if b > a]


def _dependence(first: Sequence[Allocation], again: Sequence[Allocation]) -> str:
    """The first demand with another answer at its second time; empty for none."""
    for number, (one, other) in enumerate(zip(first, again, strict=True)):
        if one.status != other.status or not np.array_equal(one.f, other.f, equal_nan=True):
            by = float(np.abs(one.f - other.f).max())
            apart = f"by {by:.2g} N" if by == by else f"as {other.status.name} after {one.status.name}"
            return (
                f"depends on earlier calls: demand {number}, asked again, is answered otherwise, {apart};"
                ' a library with a memory exports tba_reset, a program begins with "memory": true'
            )
    return ""


def _misstated(allocator: Allocator, demands: DemandSet, number: int, found: Allocation) -> str:
    """In words, a residual that a library states and its thrusts do not leave; empty for none."""
    stated = getattr(allocator, "stated_residual", None)
    if stated is None or np.isnan(stated).all() or not found.found:
        return ""
    off = np.abs(stated - (demands.vehicle.TP @ found.f - demands.taus[number]))
    if (off <= MISSTATED * demands.vehicle.wrench_scale).all():
        return ""
    by = f"{np.nanmax(off):.2g} N or N m"
    return f"states a residual of demand {number} that its thrusts do not leave, by {by}"


def _together(allocator: Allocator, inputs: Columns, answers: Sequence[Allocation]) -> str:
    """The first demand with another answer among many, in words; empty for none."""
    asked = np.resize(np.arange(len(answers)), max(len(answers), MANY))
    F, statuses = allocator.many(*(np.array(column)[asked] for column in inputs))
    for i, f, status in zip(asked.tolist(), F, statuses, strict=True):
        if status != answers[i].status or not np.array_equal(f, answers[i].f, equal_nan=True):
            return f"answers demand {i} otherwise among many than alone; tba_many does what tba_call does"
    return ""


def _growth(allocate: Callable[..., Allocation], calls: Sequence[tuple[Any, ...]]) -> str:
    """Growth of memory over a million calls, in words; empty for none."""
    before, done, end = _resident(), 0, time.perf_counter_ns() + LEAK_NS
    while done < LEAK_CALLS and time.perf_counter_ns() < end:
        for arguments in calls:
            allocate(*arguments)
        done += len(calls)
    grown = _resident() - before
    return f"its memory grows by {grown / done:,.0f} MB in a million calls" if grown > LEAK_BYTES else ""


def _resident() -> int:
    """Resident memory of this process and those that it has started [bytes]."""
    return sum(_each(_family(), lambda process: process.memory_info().rss))


def _family() -> list[psutil.Process]:
    """This process, then those that it has started, and those that they have."""
    own = psutil.Process()
    return [own, *own.children(recursive=True)]


def _each(family: Sequence[psutil.Process], number: Callable[[psutil.Process], int]) -> Iterator[int]:
    """A number of each process, 1 of one that has ended."""
    for process in family:
        try:
            yield number(process)
        except psutil.Error:
            yield 1


@contextmanager
def _captured() -> Iterator[list[str]]:
    """Keep what is printed on standard output, also by C; the list holds it at the end, if there is any."""
    import ctypes

    flush = ctypes.CDLL(None).fflush
    printed: list[str] = []
    flush(None)
    own = os.dup(1)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 1)
        try:
            yield printed
        finally:
            flush(None)
            os.dup2(own, 1)
            os.close(own)
        file.seek(0)
        if text := file.read(1000).decode(errors="replace"):
            printed.append(" ".join(text.split()))
