"""Many demands at once, as a planner or a simulation asks: 1,000 in one call of ``many``."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocation, Allocator, Status, Vehicle
from alloc.allocation import FloatArray, StatusArray
from bench.suite.answers import N_DEMANDS, inactive_sequence, judge

DEMANDS = 1000


def test_many(benchmark: BenchmarkFixture, method: str, vehicle: Vehicle, allocator: Allocator) -> None:
    """Allocate 1,000 inactive demands in one call."""
    taus = np.tile(inactive_sequence(vehicle), (DEMANDS // N_DEMANDS, 1))
    benchmark.group = f"{vehicle.name}: many(), 1,000 inactive demands"
    many: tuple[FloatArray, StatusArray] = benchmark(allocator.many, taus)
    answers = [Allocation(f, Status(status)) for f, status in zip(*many, strict=True)]
    benchmark.extra_info.update(
        vehicle=vehicle.name,
        label="inactive",
        method=method,
        formulation=allocator.formulation,
        calls=DEMANDS,
        certificate=judge(vehicle, allocator, taus, answers),
    )
