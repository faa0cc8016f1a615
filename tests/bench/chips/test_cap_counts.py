"""C under a cap on an emulated processor: it answers as Python, and what does not is seen."""

import pytest

from alloc import load_vehicle
from bench.chips import cap
from bench.chips.kernels import Kernel
from bench.chips.processors import processor
from bench.chips.toolchain import missing
from bench.record import Emulated

M4F = processor("cortex-m4f")
HEAVY = load_vehicle("bluerov2-heavy")
needs_tools = pytest.mark.skipif(bool(missing(M4F)), reason=missing(M4F) or "-")


def counted(made: Kernel) -> list[Emulated]:
    row = Emulated(
        vehicle=HEAVY.name, target=M4F.name, method="cap", scalar="float", limits=made.limits, seed=0
    )
    return list(cap.rows(row, made, HEAVY, M4F, n=30))


@needs_tools
def test_a_call_agrees_with_python() -> None:
    rows = counted(cap.kernel(HEAVY, "float", "fixed"))
    assert [each.demands for each in rows] == list(cap.SETS)
    assert all(each.agrees for each in rows), [each.distance_rel_max for each in rows]


@needs_tools
def test_answers_of_another_vehicle_are_not_agreed_on() -> None:
    assert not any(each.agrees for each in counted(cap.kernel(HEAVY.with_fault(2), "float", "fixed")))
