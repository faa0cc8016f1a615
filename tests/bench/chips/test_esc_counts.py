"""The C from thrusts to ESCs is counted on a processor that is emulated, and answers there as Python does."""

from dataclasses import replace

import pytest

from alloc import NotApplicable, load_vehicle
from bench.chips import esc
from bench.chips.processors import processor
from bench.chips.toolchain import missing
from bench.record import Emulated

HEAVY = load_vehicle("bluerov2-heavy")
M4F = processor("cortex-m4f")
ROW = Emulated(vehicle=HEAVY.name, target=M4F.name, method=esc.METHOD, scalar="float", limits="fixed", seed=0)
needs_tools = pytest.mark.skipif(bool(missing(M4F)), reason=missing(M4F) or "-")


@needs_tools
def test_eight_thrusters_are_counted_and_make_what_python_says() -> None:
    rows = list(esc.rows(ROW, esc.kernel(HEAVY, "float", "fixed"), HEAVY, M4F, n=30))
    assert [row.demands for row in rows] == list(esc.SIZES)
    for row in rows:
        assert row.agrees
        assert sum(calls for _, calls in row.instructions) == 30
        assert 200 < row.instructions[0][0] <= row.instructions[-1][0]


@needs_tools
def test_thrusts_of_another_curve_are_not_agreed_on() -> None:
    stronger = replace(HEAVY.esc[0], curve=HEAVY.esc[0].curve * 1.02)
    other = replace(HEAVY, esc=(stronger,) * HEAVY.n)
    rows = esc.rows(ROW, esc.kernel(other, "float", "fixed"), HEAVY, M4F, n=10)
    assert not any(row.agrees for row in rows)


def test_a_vehicle_without_escs_is_refused() -> None:
    with pytest.raises(NotApplicable, match="has no ESCs"):
        esc.kernel(load_vehicle("ukwial"), "float", "fixed")
