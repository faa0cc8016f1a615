"""Set-up for a vehicle: its price is paid before the first call, and again after a failure."""

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocator
from alloc.discovery import Entry, prepare
from bench.judging.question import Question
from bench.suite.answers import tell


@pytest.mark.usefixtures("allocator")
def test_setup(benchmark: BenchmarkFixture, entry: Entry, asked: Question) -> None:
    """Prepare the method for the whole vehicle; judge what the allocator answers."""
    benchmark.group = f"{asked.demands.vehicle.name}: set-up"
    allocator: Allocator = benchmark(prepare, entry, asked.demands.vehicle)
    tell(benchmark, asked, entry, allocator, [allocator(tau) for tau in asked.demands.taus])
