"""Functions that are timed as methods are, and measure the harness and the machine."""

from collections.abc import Callable
from statistics import median
from time import perf_counter_ns
from typing import Any

import numpy as np

from bench.record import Method

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
