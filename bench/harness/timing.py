"""Time calls of any function, batches for the centre and single calls for the tails; count instructions.

docs/method.md says how and why.
"""

import gc
import resource
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from statistics import median
from time import perf_counter_ns, thread_time_ns
from typing import Any, Generic, TypeVar

import numpy as np

from bench.record import Batch, Method
from bench.record.file import CanaryFile
from bench.record.measured import binned

Y = TypeVar("Y")
Columns = Sequence[Sequence[Any]]
"""The arguments of calls, argument by argument: column j holds argument j of every call."""

BATCH_NS = 2_000_000
"""Length of a batch: two clock readings vanish in it, and most batches fit between two timer interrupts."""
WARM_NS = 200_000
"""Length of the untimed calls before each batch, which fill caches and branch predictors again."""
SLOW_NS = 50_000
"""The two clock readings of a single call (about 0.1 us) are 0.2 % of a call as slow as this, so one pass of
single calls serves as a batch too."""
SINGLES = 5_000
"""Most single calls of one process; two repeats make the 10,000 calls that p99.9 needs."""
LEAST_BATCHES = 2
"""Batches that a fast method gets in each repeat, whatever its budget; a slow method gets one pass."""
_THREAD = getattr(resource, "RUSAGE_THREAD", resource.RUSAGE_SELF)  # only Linux has RUSAGE_THREAD


@dataclass
class Samples(Generic[Y]):
    """Times that were measured.

    Attributes
    ----------
    batches : calls timed together
    singles : times of single calls [ns]
    answers : of every single call and of each batch's last pass: whole passes over the inputs, in order
    timed_ns : sum of all timed calls [ns]
    """

    batches: list[Batch] = field(default_factory=list)
    singles: list[int] = field(default_factory=list)
    answers: list[Y] = field(default_factory=list)
    timed_ns: int = 0


def sample(call: Callable[..., Y], inputs: Columns, budget_ns: int, singles: int = SINGLES) -> Samples[Y]:
    """Time ``call`` over ``inputs`` for about ``budget_ns``, in whole passes and in the order of the inputs.

    Batches and single calls take turns, so that a slow spell of the machine hits both alike. A call slower
    than SLOW_NS is timed singly only, and each pass counts as a batch. At most about ``singles`` single
    calls are made of a faster one.
    """
    for arguments in islice(zip(*inputs, strict=True), 3):  # they pay for lazy imports and cold caches
        call(*arguments)
    samples: Samples[Y] = Samples()
    end = perf_counter_ns() + budget_ns
    batch = _time_singly(call, inputs, samples)
    per_call = max(1, int(median(samples.singles)))
    if per_call >= SLOW_NS:
        samples.batches.append(batch)
        while perf_counter_ns() < end:
            samples.batches.append(_time_singly(call, inputs, samples))
        return samples
    samples.singles.clear()  # the first pass of a fast call ran on cold caches
    passes = max(1, round(BATCH_NS / (per_call * len(inputs[0]))))
    warm = [column[-max(1, WARM_NS // per_call) :] for column in inputs]
    while len(samples.batches) < LEAST_BATCHES or perf_counter_ns() < end:
        deque(map(call, *warm), maxlen=0)
        samples.batches.append(_time_batch(call, inputs, passes, samples))
        if len(samples.singles) < singles:
            for _ in range(passes):
                _time_singly(call, inputs, samples)
    return samples


def _time_batch(call: Callable[..., Y], inputs: Columns, passes: int, samples: Samples[Y]) -> Batch:
    todo = [list(column) * passes for column in inputs]
    last: deque[Y] = deque(maxlen=len(inputs[0]))
    switches, cpu, wall = _switches(), thread_time_ns(), perf_counter_ns()
    # This loop runs in C and keeps the last pass; it costs 1 % of a 1 us call, as a `for` does.
    last.extend(map(call, *todo))
    wall, cpu = perf_counter_ns() - wall, thread_time_ns() - cpu
    samples.answers.extend(last)
    samples.timed_ns += wall
    return Batch(len(todo[0]), wall, cpu, _switches() - switches)


def _time_singly(call: Callable[..., Y], inputs: Columns, samples: Samples[Y]) -> Batch:
    clock, keep = perf_counter_ns, samples.answers.append
    times: list[int] = []
    switches, cpu = _switches(), thread_time_ns()
    start = clock()
    for y in map(call, *inputs):  # a step is one call, made in C, with an argument of each column
        times.append(clock() - start)
        keep(y)
        start = clock()
    cpu, switches = thread_time_ns() - cpu, _switches() - switches
    wall = sum(times)
    samples.singles += times
    samples.timed_ns += wall
    return Batch(len(times), wall, cpu, switches)


def _switches() -> int:
    return resource.getrusage(_THREAD).ru_nivcsw


@contextmanager
def no_garbage_collection() -> Iterator[None]:
    """Collect the garbage there is, freeze all other objects, and keep the collector off inside the block."""
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def tally(singles: Iterable[int]) -> list[tuple[int, int]]:
    """Single calls as a sorted histogram [(ns, count), …]; ``bench.record.measured.BIN`` says which bins."""
    return sorted(Counter(map(binned, singles)).items())


NOOP = "noop"
CANARIES = ("canary/loop", "canary/product")
YARDSTICKS = {name: Method(name=name, yardstick=True) for name in (NOOP, *CANARIES)}
"""The record's line of each yardstick, by name."""

_MATRIX = np.full((48, 48), 0.5)


def nothing(_: Any, f_min: Any = None, f_max: Any = None) -> None:
    """Do nothing: the time of a call is what the timing loop itself costs."""


def loop(*_: Any) -> None:
    """Fixed work in Python bytecode, a few us: the spread of its times is the machine's."""
    total = 0
    for i in range(400):
        total += i


def product(*_: Any) -> None:
    """Fixed work in BLAS, a few us: one matrix product."""
    _MATRIX.dot(_MATRIX)


def yardstick(name: str) -> Callable[..., None]:
    """The yardstick of that name."""
    return {NOOP: nothing, CANARIES[0]: loop, CANARIES[1]: product}[name]


def canary_ns() -> int:
    """Median time of the fixed loop now [ns]; where it drifts within a run, the machine has changed."""
    times = []
    for _ in range(25):
        start = perf_counter_ns()
        loop()
        times.append(perf_counter_ns() - start)
    return int(median(times))


CANARY_BUDGET_NS = 1_000_000_000
"""Time spent on each canary: some 500 batches."""


def measure_canaries() -> CanaryFile:
    """Time the canaries here, as a run does."""
    from bench.harness import machine  # no worker describes it

    median_us = {}
    for name in CANARIES:
        with no_garbage_collection():
            batches = sample(yardstick(name), [[None] * 100], CANARY_BUDGET_NS, singles=0).batches
        times = sorted(batch.wall_ns / batch.calls for batch in batches)
        median_us[name] = times[len(times) // 2] / 1000
    return CanaryFile(1, machine.describe(), median_us)


CALLGRIND = ("valgrind", "--vgdb=no", "--tool=callgrind")
"""Valgrind waits for no debugger (vgdb), whose pipes would stay in the temporary folder after a kill."""


def instruction_totals(out: Path) -> list[int]:
    """Instructions in each profile that callgrind dumped on the way, in order.

    They are called ``out.1``, ``out.2``, …, where ``out`` is what it was given as ``--callgrind-out-file``.
    """
    profiles = sorted(out.parent.glob(f"{out.name}.*"), key=lambda path: int(path.suffix[1:]))
    lines = (line for path in profiles for line in path.read_text(encoding="utf-8").splitlines())
    return [int(line.split()[1]) for line in lines if line.startswith("totals:")]
