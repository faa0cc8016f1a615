"""One call at the control rate; tables show the time of one, out of rounds of 1,000."""

from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocation, Allocator
from alloc.discovery import Entry
from bench.judging.question import Question
from bench.suite.answers import N_DEMANDS, of_one, tell

CALLS = 1000


def test_call(
    benchmark: BenchmarkFixture, entry: Entry, start: str, asked: Question, allocator: Allocator
) -> None:
    """Allocate a path of demands again and again; judge the answers of the last pass."""
    demands = asked.demands
    rows = [list(side) for side in (demands.taus, demands.f_min, demands.f_max) if side is not None]

    def calls() -> list[Allocation]:
        for _ in range(CALLS // N_DEMANDS):
            answers = list(map(allocator, *rows))
        return answers

    benchmark.group = f"{demands.vehicle.name}: one call, {demands.name} demands"
    answers = benchmark(calls)
    of_one(benchmark, CALLS)
    tell(benchmark, asked, entry, allocator, answers, start=start)
