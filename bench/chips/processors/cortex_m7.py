"""Cycles of traced calls on a Cortex-M7, as an interval, from published measurements: Arm has no table.

Measured on STM32H743 and STM32H730, code and data in caches or tightly coupled memory: jnk0le's "pipeline
cycle test" and quinapalus.com/cm7cycles.html. What they leave open is width:

- Two instructions a cycle at best, one at worst. Arithmetic of the FPU is one a cycle at best, as are loads
  and stores of doubles, beside which nothing goes.
- A sum of doubles occupies the FPU for 1 to 3 cycles and a product for 4 or 5, depending on the numbers.
- At worst each result is waited for as long as any of its users was seen to wait.
- A branch is foreseen, or costs 8 more. What is measured nowhere (minimum, comparison, selection, moving
  flags) takes at most as long as a sum.
"""

import re
from typing import NamedTuple

import numpy as np

from alloc.allocation import IndexArray
from bench.chips.instructions import (
    BRANCHES,
    MANY,
    ONE,
    WORDS,
    Cycles,
    Executed,
    Trace,
    Unpublished,
    listed,
    plain,
)
from bench.chips.processors import cortex_m

LONGEST = 200_000
"""Instructions of a call that is followed at most: OSQP's C takes a hundred times as many."""
MISSED = 8
"""Cycles that a branch costs which was not foreseen: 6 to 8."""


class Cost(NamedTuple):
    """Cycles of one instruction.

    Attributes
    ----------
    least : cycles of the FPU, or of the whole processor where it is ``alone``; 0 for an integer instruction
    most : cycles until the next instruction may start, at worst
    latency : cycles until its result can be used, at worst
    alone : whether nothing starts in the same cycle
    """

    least: float
    most: int
    latency: int
    alone: bool = False


INTEGER = Cost(0, 1, 2)
UNMEASURED = Cost(0.5, 3, 3)
SINGLE = {"vadd": Cost(1, 1, 3), "vsub": Cost(1, 1, 3), "vmul": Cost(1, 1, 3), "vnmul": Cost(1, 1, 3)}
SINGLE |= dict.fromkeys(("vfma", "vfms", "vfnma", "vfnms", "vmla", "vmls", "vnmla", "vnmls"), Cost(1, 1, 6))
SINGLE |= {"vdiv": Cost(16, 16, 16), "vsqrt": Cost(14, 14, 14)}
DOUBLE = {"vadd": Cost(1, 3, 3), "vsub": Cost(1, 3, 3), "vmul": Cost(4, 5, 5), "vnmul": Cost(4, 5, 5)}
DOUBLE |= dict.fromkeys(("vfma", "vfms", "vfnma", "vfnms", "vmla", "vmls", "vnmla", "vnmls"), Cost(5, 10, 10))
DOUBLE |= {"vdiv": Cost(2, 30, 30), "vsqrt": Cost(2, 30, 30)}
NOWHERE = {"vminnm", "vmaxnm", "vcmp", "vcmpe", "vabs", "vneg", "vmov", "vcvt", "vcvtr", "vmrs", "vmsr"}
NOWHERE |= {f"vsel{condition}" for condition in ("eq", "ge", "gt", "vs")}


class Line(NamedTuple):
    """Properties of an instruction that the walk over a call needs.

    Attributes
    ----------
    cost : what it takes
    touched, writes : its registers, doubles as halves
    unforeseen : whether a condition decides where execution goes on, or whether it does anything
    direct : whether it branches to an address that stands in it
    address, following : where it lies, and where execution goes on unless it branches
    """

    cost: Cost
    touched: list[str]
    writes: list[str]
    unforeseen: bool
    direct: bool
    address: int
    following: int


def cycles(trace: Trace) -> list[Cycles]:
    """Cycles of each call; raises Unpublished for what nobody measured, or a call that is too long."""
    executed = {i for call in trace.calls for i in np.unique(_checked(call)).tolist()}
    lines = {i: _line(trace.code[i]) for i in executed}
    return [_call([lines[i] for i in call.tolist()]) for call in trace.calls]


def _checked(call: IndexArray) -> IndexArray:
    if len(call) > LONGEST:
        raise Unpublished(f"{len(call)} instructions are too many to follow")
    return call


def _line(one: Executed) -> Line:
    conditional = one.name[0] == "b" and len(one.name) == 3 and one.name not in ONE
    return Line(
        cost=_cost(one),
        touched=_halves(one.registers()),
        writes=_halves(one.writes),
        unforeseen=conditional or one.conditional,
        direct=one.name in ("b", "bl"),
        address=one.address,
        following=one.following,
    )


def _call(call: list[Line]) -> Cycles:
    others = fpu = alone = 0.0
    now, ready = 0, dict[str, int]()
    last = len(call) - 1
    for i, one in enumerate(call):
        cost = one.cost
        if cost.alone:
            alone += cost.least
        else:
            others += 1
            fpu += cost.least
        for register in one.touched:
            if ready.get(register, 0) > now:
                now = ready[register]
        until = now + cost.latency
        for register in one.writes:
            ready[register] = until
        leaves = not one.direct and (i == last or call[i + 1].address != one.following)
        now += cost.most + (MISSED if one.unforeseen or leaves else 0)
    return Cycles(int(alone + max(others / 2, fpu)), now)


def _cost(one: Executed) -> Cost:
    name = plain(one)
    double = bool(one.operands) and one.operands[0].startswith("d")
    known = (DOUBLE if double else SINGLE).get(name)
    if known:
        return known
    if name in MANY:
        least = -(-listed(one) // 2)
        return Cost(least, least + 2, least + 3, alone=True)
    if name in WORDS:
        return Cost(1, 1, 3, alone=True) if double else Cost(0, 1, 3)
    if name in ("ldrd", "strd"):
        return Cost(1, 2, 3, alone=True)
    if name in ("sdiv", "udiv"):
        return Cost(1, 12, 12)
    if name in NOWHERE:
        return UNMEASURED
    integer = name in ONE or name in BRANCHES or name in ("mla", "mls", "tbb", "tbh", "nop")
    if integer or re.fullmatch("it[te]{0,3}", name) or (name[0] == "b" and len(name) == 3):
        return INTEGER
    raise Unpublished(one.name)


def _halves(registers: set[str]) -> list[str]:
    """Registers with a double as the two singles that it is made of."""
    found = []
    for name in registers:
        number = int(name[1:]) if name[1:].isdigit() else -1
        found += [f"s{2 * number}", f"s{2 * number + 1}"] if name[0] == "d" else [name]
    return found


PROCESSOR = cortex_m(
    "-mcpu=cortex-m7",
    "-mfpu=fpv5-d16",
    machine="mps2-an500",
    tick_hz=25_000_000,
    scalars=("double",),
    cpi=(0.5, 4.0),
    basis="Arm publishes none; assumed: at best two at a time, at worst each waits 4 cycles for a"
    " double-precision sum before it (latency in LLVM's ARMScheduleM7.td). Cache misses come on top",
    goal=1.0,
    cycles=cycles,
)
