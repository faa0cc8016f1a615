"""Time of fixed work on this machine, from which times on another machine are estimated."""

from bench.harness import machine
from bench.harness.timing import CANARIES, no_garbage_collection, sample, yardstick
from bench.record.canary import CanaryFile

BUDGET_NS = 1_000_000_000
"""Time spent on each canary: some 500 batches."""


def measure() -> CanaryFile:
    """Time the canaries here, as a run does."""
    median_us = {}
    for name in CANARIES:
        with no_garbage_collection():
            batches = sample(yardstick(name), [[None] * 100], BUDGET_NS, singles=0).batches
        times = sorted(batch.wall_ns / batch.calls for batch in batches)
        median_us[name] = times[len(times) // 2] / 1000
    return CanaryFile(1, machine.describe(), median_us)
