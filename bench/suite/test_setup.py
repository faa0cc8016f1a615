"""Getting ready for a vehicle: what is paid once before the first call, and again after a failure."""

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from alloc import Allocator, Vehicle, build
from bench.suite.answers import inactive_sequence, judge


@pytest.mark.usefixtures("allocator")
def test_setup(benchmark: BenchmarkFixture, method: str, vehicle: Vehicle) -> None:
    """Build the allocator anew for the whole vehicle; what it then answers is judged."""
    benchmark.group = f"{vehicle.name}: set-up"
    allocator: Allocator = benchmark(build, method, vehicle)
    taus = inactive_sequence(vehicle)
    benchmark.extra_info.update(
        vehicle=vehicle.name,
        label="inactive",
        method=method,
        formulation=allocator.formulation,
        certificate=judge(vehicle, allocator, taus, [allocator(tau) for tau in taus]),
    )
