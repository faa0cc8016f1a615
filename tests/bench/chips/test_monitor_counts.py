"""The C that accuses thrusters is counted on a processor that is emulated, and is cheap."""

from pathlib import Path

import numpy as np
import pytest

from alloc import list_vehicles, load_vehicle
from alloc.program import Scalar
from bench.chips import monitor
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.kernels import build_kernel
from bench.chips.processors import processor
from bench.chips.toolchain import missing
from bench.record import Emulated

M4F = processor("cortex-m4f")
needs_tools = pytest.mark.skipif(bool(missing(M4F)), reason=missing(M4F) or "-")
MOST = 4
"""Most instructions of a call, relative to those of pinv's C: a product with T and one with its transpose."""
EVERYWHERE: dict[str, tuple[Scalar, ...]] = {
    "aarch64": ("double", "float"),
    "cortex-m33": ("float",),
    "cortex-m4f": ("float",),
    "cortex-m7": ("double", "float"),
}


@pytest.mark.parametrize(
    ("name", "target", "scalar"),
    [
        ("bluerov2-heavy", "cortex-m4f", "float"),
        ("bluerov2-heavy", "cortex-m33", "float"),  # has the fewest registers to spare
        *(
            pytest.param(name, target, scalar, marks=pytest.mark.long)
            for name in list_vehicles()
            for target, scalars in EVERYWHERE.items()
            for scalar in scalars
        ),
    ],
)
def test_a_call_agrees_with_python_and_takes_at_most_four_times_what_pinv_takes(
    name: str, target: str, scalar: Scalar, tmp_path: Path
) -> None:
    if lacking := missing(processor(target)):
        pytest.skip(lacking)
    vehicle, on = load_vehicle(name), processor(target)
    row = Emulated(
        vehicle=vehicle.name, target=on.name, method="monitor", scalar=scalar, limits="fixed", seed=0
    )
    rows = list(monitor.rows(row, monitor.kernel(vehicle, scalar, "fixed"), vehicle, on, n=30))
    assert [each.demands for each in rows] == list(monitor.SETS)
    assert all(each.agrees for each in rows)
    pinv = link(build_kernel("pinv@native", vehicle, scalar), on, tmp_path)
    most = count(pinv, np.ones((1, vehicle.k))).instructions.max()
    assert max(each.instructions[-1][0] for each in rows) <= MOST * most


@needs_tools
def test_answers_of_another_vehicle_are_not_agreed_on() -> None:
    one, other = load_vehicle("bluerov2-heavy"), load_vehicle("nautilus")
    row = Emulated(
        vehicle=one.name, target=M4F.name, method="monitor", scalar="float", limits="fixed", seed=0
    )
    rows = monitor.rows(row, monitor.kernel(other, "float", "fixed"), one, M4F, n=10)
    assert not any(each.agrees for each in rows)
