"""Cost of flash in a call: lines counted by hand, and five functions that a board has timed."""

from pathlib import Path

import numpy as np
import pytest

from alloc import load_vehicle
from bench.chips.boards import Flash, Touched, boards, touched, waiting
from bench.chips.count import count
from bench.chips.cycles import trace
from bench.chips.image import link
from bench.chips.instructions import Cycles
from bench.chips.kernels import build_kernel
from bench.demands import build_demands
from flown_cycles import FUNCTIONS
from tests.emulators import available

SMALL = Flash(line=16, waits=5, code_lines=4, data_lines=2)
NOTHING = np.zeros(0, dtype=np.intp)
(F446,) = [board for board in boards("cortex-m4f") if board.name == "stm32f446"]

COUNTED = {
    "alloc_wrench_to_thrust": (Cycles(1416, 1712), Touched(0, 0, 14), Touched(31, 4, 15)),
    "alloc_v2_wrench_to_thrust": (Cycles(840, 921), Touched(0, 0, 13), Touched(10, 1, 15)),
    "alloc_v2p_wrench_to_thrust": (Cycles(999, 1203), Touched(0, 0, 14), Touched(27, 5, 15)),
    "alloc_thrust_to_pwm": (Cycles(301, 336), Touched(0, 0, 0), Touched(7, 3, 3)),
    "alloc_slew_step": (Cycles(194, 239), Touched(0, 0, 0), Touched(8, 1, 2)),
}
"""Cycles of the costliest call of five flown functions without wait states, and what it touches of the flash
warm and cold, by GCC 12.2: docs/studies/flown_cycles.py prints it, and has what their board took. By which
compiler nobody says."""
MOST = {function.entry: function.measured[2] for function in FUNCTIONS}


@pytest.mark.parametrize("name", MOST)
def test_what_a_board_took_at_most_lies_in_the_interval_of_that_board(name: str) -> None:
    without, warm, cold = COUNTED[name]
    waits = waiting(F446.flash, warm, cold)
    assert without.low + waits.low <= MOST[name] <= without.high + waits.high


def test_without_waits_for_the_flash_the_board_is_above_all_five() -> None:
    """v2 by most for what it does: its table takes thirteen lines, and the cache of tables has eight."""
    assert all(MOST[name] > without.high for name, (without, _, _) in COUNTED.items())
    assert COUNTED["alloc_v2_wrench_to_thrust"][1].data * F446.flash.waits == 65


def test_a_table_of_192_bytes_costs_every_call_about_what_the_board_showed() -> None:
    """v2 took 63 to 64 cycles more than it does without waits, in each call: 12 lines or 13, as they lie."""
    code, table = np.arange(0, 64, 4), np.arange(0x400, 0x400 + 192, 4)
    warm, _ = touched(F446.flash, code, table)
    assert waiting(F446.flash, warm, warm).low == 12 * 5
    assert touched(F446.flash, code, table[: 8 * 4])[0].data == 0  # eight lines are kept


def test_lines_that_fit_the_caches_cost_a_second_call_nothing() -> None:
    code, data = np.arange(0, 48, 2), np.arange(0x100, 0x110, 4)
    warm, cold = touched(SMALL, code, data)
    assert warm == (0, 0, 0)
    assert cold == (3, 1, 2)  # at the worst place 48 bytes lie in four lines and 16 in two
    assert waiting(SMALL, warm, cold) == (0, 3 * 5 + (1 + 2) * 11)


def test_a_table_longer_than_its_cache_is_read_anew_in_each_call() -> None:
    """The line used longest ago makes place, so a table of three lines in a cache of two is never there."""
    warm, cold = touched(SMALL, np.array([0, 2]), np.arange(0, 48, 4))
    assert (warm.data, cold.data) == (3, 4)
    assert waiting(SMALL, warm, cold).low == 3 * 5


def test_a_branch_to_another_line_may_wait_longer_than_what_comes_next() -> None:
    """Each line once: straight on, and then with a jump over four lines."""
    _, straight = touched(SMALL, np.arange(0, 32, 4), NOTHING)
    _, jumps = touched(SMALL, np.array([*range(0, 16, 4), *range(80, 96, 4)]), NOTHING)
    assert straight == (2, 1, 0)
    assert jumps.jumped > straight.jumped
    assert waiting(SMALL, straight, jumps).high > waiting(SMALL, straight, straight).high


def test_code_longer_than_its_cache_waits_for_its_branches_in_every_call() -> None:
    code = np.concatenate([np.arange(place, place + 16, 4) for place in (0, 160, 320, 480, 640)])
    warm, _ = touched(SMALL, code, NOTHING)
    assert warm.jumped == 5


def test_a_trace_knows_each_constant_that_a_kernel_loads_from_flash(tmp_path: Path) -> None:
    """A second way: every executed load whose address is relative to pc; a pinv has no other tables."""
    vehicle = load_vehicle("tiburon")
    image = link(build_kernel("pinv@native", vehicle, "float"), available("cortex-m4f"), tmp_path)
    taus = build_demands("active", vehicle, 0, 2).taus
    followed = trace(image, taus, count(image, taus).instructions)
    for call, loads in zip(followed.calls, followed.loads, strict=True):
        executed = [followed.code[i] for i in call]
        literals = [
            one for one in executed if one.name in ("vldr", "ldr", "tbh") and "pc" in str(one.operands)
        ]
        assert len(loads) == len(literals) > 20
        assert loads.min() > image.entry
