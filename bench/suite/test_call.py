"""One call at the control rate: 1,000 calls a round (ms in the table are µs a call)."""

from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocation, Allocator, Entry
from bench.judging.question import Question
from bench.suite.answers import N_DEMANDS, tell

CALLS = 1000


def test_call(
    benchmark: BenchmarkFixture, entry: Entry, start: str, asked: Question, allocator: Allocator
) -> None:
    """Allocate a path of demands again and again; judge the answers of the last pass."""
    rows = list(asked.demands.taus)

    def calls() -> list[Allocation]:
        for _ in range(CALLS // N_DEMANDS):
            answers = [allocator(tau) for tau in rows]
        return answers

    benchmark.group = f"{asked.demands.vehicle.name}: 1,000 calls, {asked.demands.name} demands"
    answers = benchmark(calls)
    tell(benchmark, asked, entry, allocator, answers, start=start, calls=CALLS)
