"""Many demands at once, as a planner or a simulation asks; tables show the time of one in a call of 1,000."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocation, Allocator, Status
from alloc.allocation import FloatArray, StatusArray
from alloc.discovery import Entry
from bench.judging.question import Question
from bench.suite.answers import N_DEMANDS, of_one, tell

DEMANDS = 1000


def test_many(benchmark: BenchmarkFixture, entry: Entry, asked: Question, allocator: Allocator) -> None:
    """Allocate 1,000 inactive demands in one call."""
    taus = np.tile(asked.demands.taus, (DEMANDS // N_DEMANDS, 1))
    benchmark.group = f"{asked.demands.vehicle.name}: one of 1,000 in many(), {asked.demands.name} demands"
    many: tuple[FloatArray, StatusArray] = benchmark(allocator.many, taus)
    of_one(benchmark, DEMANDS)
    # Answers that share memory are judged wrong, and rows of one array share it; so each row is copied.
    answers = [Allocation(f.copy(), Status(s)) for f, s in zip(*many, strict=True)]
    tell(benchmark, asked, entry, allocator, answers)
