"""libthrustbench answers as the methods in Python do, on every shipped vehicle and after any failures."""

from collections.abc import Iterator

import numpy as np
import pytest

from alloc import NotApplicable, Vehicle, build
from alloc.allocation import FloatArray
from alloc.library import calls

CLOSE = 1e-9
"""Share of the largest limit: what methods promise; 1e-13 was the most seen."""


def failing(vehicle: Vehicle) -> Iterator[Vehicle]:
    """Whole, each thruster off, two off, one weak."""
    yield vehicle
    yield from (vehicle.with_fault(i) for i in range(vehicle.n))
    yield vehicle.with_fault(0).with_fault(1)
    yield vehicle.with_fault(1, 0.4)


def asked(vehicle: Vehicle, rng: np.random.Generator) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Demands inside, near the edge of and outside the attainable set, within limits of each call."""
    for size in np.resize([0.3, 0.9999, 2.0], 24):
        low, high = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, vehicle.n)), axis=0)
        middle, corner = (low + high) / 2, np.where(rng.random(vehicle.n) < 0.5, low, high)
        yield (middle + size * (corner - middle)) @ vehicle.TP.T, low, high
        yield size * rng.uniform(vehicle.f_min, vehicle.f_max) @ vehicle.TP.T, vehicle.f_min, vehicle.f_max


@pytest.mark.parametrize("method", calls())
def test_status_thrusts_and_shares_are_python_s(
    method: str, vehicle: Vehicle, rng: np.random.Generator
) -> None:
    for case in failing(vehicle):
        try:
            expected, library = build(method, case), build(f"{method}@library", case)
        except NotApplicable:
            continue
        for tau, low, high in asked(case, rng):
            one, other = expected(tau, low, high), library(tau, low, high)
            assert other.status == one.status
            np.testing.assert_allclose(other.f, one.f, rtol=0, atol=CLOSE * case.f_scale)
            np.testing.assert_allclose(other.share, one.share, rtol=0, atol=CLOSE)
