"""Cycles of a call are what Arm's manual says of it: its examples, and what each rule adds to both ends."""

from pathlib import Path

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.program import Scalar
from bench.chips.count import count
from bench.chips.cycles import cycles, disassembly, trace
from bench.chips.image import link
from bench.chips.instructions import Cycles, Executed, Trace, Unpublished
from bench.chips.kernels import build_kernel
from bench.chips.processors.cortex_m4f import cycles as cortex_m4f
from bench.chips.processors.cortex_m7 import cycles as cortex_m7
from bench.demands import build_demands
from tests.emulators import available


def run(*lines: str, size: int = 2, at: int = 0) -> Trace:
    """A call that executes these lines in order, and then returns."""
    known = []
    for line, width in [*((line, size) for line in lines), ("bx lr", 2)]:
        name, _, rest = line.partition(" ")
        operands = tuple(part.strip().replace(";", ",") for part in rest.split(",") if part)
        known.append(Executed(at, at + width, name, operands, conditional=False))
        at += width
    return Trace(known, [np.arange(len(known))])


def m4f(*lines: str, size: int = 2, at: int = 0) -> Cycles:
    """Cycles without the return, which takes 1 and 1 to 3 to refill the pipeline."""
    (span,) = cortex_m4f(run(*lines, size=size, at=at))
    return Cycles(span.low - 2, span.high - 4)


@pytest.mark.parametrize(
    ("lines", "cycles"),
    [
        (("ldr r0, [r1]", "ldr r1, [r2]"), 3),
        (("ldr r0, [r1; r5]", "ldr r1, [r2]", "ldr r2, [r3; #4]"), 4),
        (("ldr r0, [r1; r2]", "str r0, [r3; #20]"), 3),
        (("add r0, r1, r2", "str r3, [r5; #4]", "mov r0, r1"), 3),
        (("push {r4-r7; lr}",), 6),
        (("vldr d0, [r0]",), 3),
        (("vpush {d8-d9}",), 5),
        (("ldrd r0, r1, [r2]",), 3),
        (("vmla s0, s1, s2",), 3),
    ],
)
def test_the_manual_s_examples_have_the_manual_s_cycles(lines: tuple[str, ...], cycles: int) -> None:
    """DDI 0439, section 3.3.2 and tables 3-1 and 7-1: examples of loads and stores with their totals."""
    assert m4f(*lines) == (cycles, cycles)


def test_a_result_that_the_next_instruction_reads_costs_one_more() -> None:
    apart = ("vmul s0, s1, s2", "vadd s3, s4, s5")
    assert m4f(*apart) == (2, 2)
    assert m4f("vmul s0, s1, s2", "vadd s3, s0, s5") == (3, 3)
    assert m4f("vmul s0, s1, s2", "vadd s0, s4, s5") == (2, 2)  # written, not read


def test_an_address_that_was_just_calculated_costs_one_more() -> None:
    assert m4f("add r1, r2, r3", "ldr r0, [r1]") == (4, 4)
    assert m4f("add r4, r2, r3", "ldr r0, [r1]") == (3, 3)


def test_loads_of_four_bytes_may_fail_to_overlap_where_they_begin_between_words() -> None:
    """Seen on a board, so both are in the interval; at word boundaries they overlap."""
    lines = ("ldr r0, [r1]", "ldr r4, [r2]")
    assert m4f(*lines, size=4) == (3, 3)
    assert m4f(*lines, size=4, at=2) == (3, 4)


def test_a_branch_that_is_taken_refills_the_pipeline_in_one_or_two_cycles() -> None:
    """One more where its target has 4 bytes and begins between two words, which are fetched one by one."""
    stays = run("cmp r0, #1", "ble 100", "mov r1, r2")
    assert cortex_m4f(stays) == [(2 + 1 + 2, 2 + 1 + 4)]
    for size, at, extra in ((2, 0, 0), (2, 2, 0), (4, 0, 0), (4, 2, 1)):
        known = run("cmp r0, #1", "ble 100", "mov r1, r2", "add r1, r2, r3", size=size, at=at).code
        goes = Trace(known, [np.array([0, 1, 3, 4])])  # over the mov
        assert cortex_m4f(goes) == [(1 + 2 + 1 + 2 + extra, 1 + 3 + 1 + 4 + extra)]


def test_a_table_branch_takes_six_cycles_as_the_manual_counts_them() -> None:
    known = run("tbb [pc; r1]", "mov r1, r2", "mov r3, r4").code
    assert cortex_m4f(Trace(known, [np.array([0, 2, 3])])) == [(6 + 1 + 2, 6 + 1 + 4)]


def test_a_division_hides_behind_what_follows_until_the_fpu_is_asked_again() -> None:
    """14 cycles, of which as many may vanish as integer instructions take meanwhile, but never the first."""
    adds = ("add r0, r1, r2",)
    assert m4f("vdiv s0, s1, s2", "vadd s3, s4, s5") == (15, 15)
    assert m4f("vdiv s0, s1, s2", *adds * 5, "vadd s3, s4, s5") == (15, 20)
    assert m4f("vdiv s0, s1, s2", *adds * 20, "vadd s3, s4, s5") == (22, 35)
    assert m4f("vdiv s0, s1, s2", *adds * 5, "vdiv s3, s4, s5", "vadd s6, s7, s8") == (29, 34)


def test_many_wide_instructions_between_words_may_wait_for_a_fetch() -> None:
    """From three on, one cycle for each stretch of loads and stores or of others."""
    add, store = "add r0, r1, r2", "str r3, [r5]"
    assert m4f(*[add] * 9, size=4) == (9, 9)
    assert m4f(add, add, size=4, at=2) == (2, 2)
    assert m4f(*[add] * 9, size=4, at=2) == (9, 10)
    assert m4f(*[add] * 3, store, store, *[add] * 3, size=4, at=2) == (8, 11)


def test_an_instruction_in_no_table_is_unknown_and_not_guessed() -> None:
    for model in (cortex_m4f, cortex_m7):
        with pytest.raises(Unpublished, match="frobnicate"):
            model(run("frobnicate r0, r1"))


def test_on_a_cortex_m7_two_integer_instructions_share_a_cycle_at_best_and_doubles_never_do() -> None:
    (many,) = cortex_m7(run(*["add r0, r1, r2", "add r3, r4, r5"] * 10))
    assert many.low == 21 // 2
    (sums,) = cortex_m7(run(*[f"vadd d{i}, d14, d15" for i in range(10)]))
    assert sums.low == 10
    assert sums.high >= 30
    (chain,) = cortex_m7(run(*["vadd s0, s0, s1"] * 10))
    assert chain.high - 8 >= 28  # each waits three cycles for the one before


@pytest.mark.parametrize(
    ("name", "scalar", "method", "ratio"),
    [
        ("cortex-m4f", "float", "nullspace@native", 1.4),
        ("cortex-m4f", "float", "pinv@native", 1.5),
        ("cortex-m7", "double", "nullspace@native", 4.0),
    ],
)
def test_a_kernel_s_interval_holds_its_instructions_and_is_narrow(
    name: str, scalar: Scalar, method: str, ratio: float, tmp_path: Path
) -> None:
    """A Cortex-M4F starts at most one instruction a cycle, an M7 two."""
    vehicle = load_vehicle("bluerov2-heavy")
    image = link(build_kernel(method, vehicle, scalar), available(name), tmp_path)
    taus = build_demands("active", vehicle, 0, 10).taus
    counted = count(image, taus)
    span = cycles(image, taus, counted)[name]
    assert span.high <= ratio * span.low
    assert span.low >= counted.instructions.max() * (0.9 if name == "cortex-m4f" else 0.5)
    traced = trace(image, taus, counted.instructions)
    assert sorted(map(len, traced.calls)) == sorted(counted.instructions.tolist())
    assert {one.address for one in disassembly(image.path, image.processor.tools)} >= {image.entry}
