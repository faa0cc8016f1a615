"""The longest way through a disassembly: loops count all their rounds, calls all that they take."""

import pytest

from bench.chips.bounds import Unbounded, longest

HEAD = "\n{entry:08x} <{name}>:\n"


def disassembly(name: str, entry: int, lines: str) -> str:
    """Output of objdump for a function with one instruction a line, two bytes each."""
    rows = [line.strip() for line in lines.strip().splitlines()]
    return HEAD.format(entry=entry, name=name) + "\n".join(
        f"    {entry + 2 * i:x}:\t{row.replace(' ', chr(9), 1)}" for i, row in enumerate(rows)
    )


def test_of_two_ways_the_longer_one_counts() -> None:
    """cmp, beq, then three or one instruction to the return: six."""
    code = disassembly("f", 0x100, "cmp r0, #0\nbeq.n 108 <f+0x8>\nadds r1, #1\nadds r1, #2\nbx lr")
    assert longest(code, 0x100, rounds=1) == 5


def test_a_loop_counts_as_often_as_it_may_go_round() -> None:
    """One instruction before, two in the loop, the return behind."""
    code = disassembly("f", 0x100, "movs r1, #0\nadds r1, #1\nbne.n 102 <f+0x2>\nbx lr")
    assert longest(code, 0x100, rounds=4) == 1 + 4 * 2 + 1


def test_a_call_counts_with_all_it_takes() -> None:
    outer = disassembly("f", 0x100, "bl 200 <g>\nbx lr")
    inner = disassembly("g", 0x200, "adds r1, #1\nbx lr")
    assert longest(outer + inner, 0x100, rounds=1) == 2 + 2


def test_a_table_leads_to_what_nothing_else_leads_to() -> None:
    """The switch jumps to one of two cases; the longer has three instructions."""
    code = disassembly("f", 0x100, "tbb [pc, r0]\n.short 0x0201\nbx lr\nadds r1, #1\nadds r1, #2\nbx lr")
    assert longest(code, 0x100, rounds=1) == 1 + 3


def test_a_call_of_itself_has_no_longest_way() -> None:
    with pytest.raises(Unbounded, match="calls itself"):
        longest(disassembly("f", 0x100, "bl 100 <f>\nbx lr"), 0x100, rounds=1)


def test_a_loop_in_a_loop_counts_all_its_rounds_in_each() -> None:
    """Twice (one instruction, twice two, two more), one before and the return behind."""
    code = disassembly(
        "f",
        0x100,
        "movs r1, #0\nmovs r2, #0\nadds r2, #1\nbne.n 104 <f+0x4>\nadds r1, #1\nbne.n 102 <f+0x2>\nbx lr",
    )
    assert longest(code, 0x100, rounds=2) == 1 + 2 * (1 + 2 * 2 + 2) + 1
