"""Rows that measure the harness and the machine instead of a method."""

from collections.abc import Callable
from statistics import median
from time import perf_counter_ns
from typing import Any

import numpy as np

from bench.record import Method

NOOP = "noop"
CANARIES = ("canary/loop", "canary/product")
YARDSTICKS = {name: Method(name=name, yardstick=True) for name in (NOOP, *CANARIES)}
"""What the record keeps of each, by its name."""

_MATRIX = np.full((48, 48), 0.5)


def nothing(_: Any) -> None:
    """An allocator that does nothing: what the timing loop itself costs."""


def loop(_: Any) -> None:
    """Python bytecode only, a few us: fixed work, so its spread is the machine's."""
    total = 0
    for i in range(400):
        total += i


def product(_: Any) -> None:
    """One numpy product, a few us: fixed work in BLAS."""
    _MATRIX.dot(_MATRIX)


def yardstick(name: str) -> Callable[[Any], None]:
    """The yardstick of that name."""
    return {NOOP: nothing, CANARIES[0]: loop, CANARIES[1]: product}[name]


def canary_ns() -> int:
    """Median time of the fixed loop now [ns]; drift of it within a run means the machine changed."""
    times = []
    for _ in range(25):
        start = perf_counter_ns()
        loop(None)
        times.append(perf_counter_ns() - start)
    return int(median(times))
