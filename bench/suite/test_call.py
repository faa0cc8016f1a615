"""One call at the control rate: 1,000 calls a round (ms in the table are µs a call)."""

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocation, Allocator, Vehicle
from bench.suite.answers import N_DEMANDS, inactive_sequence, judge

CALLS = 1000


@pytest.mark.benchmark(warmup_iterations=1)
def test_call(
    benchmark: BenchmarkFixture, method: str, start: str, vehicle: Vehicle, allocator: Allocator
) -> None:
    """Allocate a path of inactive demands, again and again, and judge the last time round."""
    taus = inactive_sequence(vehicle)
    rows = list(taus)

    def calls() -> list[Allocation]:
        for _ in range(CALLS // N_DEMANDS):
            answers = [allocator(tau) for tau in rows]
        return answers

    benchmark.group = f"{vehicle.name}: 1,000 calls, inactive demands"
    answers = benchmark(calls)
    benchmark.extra_info.update(
        vehicle=vehicle.name,
        label="inactive",
        method=method,
        start=start,
        formulation=allocator.formulation,
        calls=CALLS,
        certificate=judge(vehicle, allocator, taus, answers),
    )
