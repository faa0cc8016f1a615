"""Cycles of traced calls on a Cortex-M4F, as an interval: each instruction against published timing.

Arm's Cortex-M4 technical reference manual (DDI 0439) has a table of instructions (3-1), one of the FPU's
(7-1) and rules for loads and stores (3.3); Texas Instruments reprints them in SWCU192 (tables 3-25 and 3-27)
and SWCU185. They hold at zero wait states. Two people measured more: jnk0le, "pipeline cycle test", on an
STM32F407, and compendium.i-0.nl, with the code in flash. What all leave open makes the interval wide:

- P, the cycles to refill the pipeline after a branch that is taken, is 1 to 3 by alignment and width of the
  target and whether its address was known early. A target of 4 bytes that begins between words is seen in the
  trace and takes one of the two cycles between; the other is open. Loads of a branch's target take 3.
- A load or store behind a load takes 1, but boards show 2 where its 4 bytes don't begin at a word. A load of
  a literal may meet the fetch unit: 1 more. Nobody says how the FPU's loads and stores overlap: 1 or 2.
- Three instructions of 4 bytes in a row that begin between words wait for a fetch, measured as 1 cycle, or
  more where loads and stores are among others: here 0 or 1 for each stretch of the one or the other.
- An instruction whose condition may be false takes its own time or 1. IT and NOP may vanish behind 2 bytes.
- A division or square root takes 14, but what follows goes on until it is an instruction of the FPU.
"""

import re
from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, IndexArray
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

EARLY, LATE = 1, 2
"""Cycles to refill the pipeline where the target's address was known early, and where it was not; 1 more for
a target of 4 bytes that begins between words."""
DIVIDED = {"vdiv", "vsqrt"}
A_GROUP = 3
"""Instructions of 4 bytes between words, from which on the fetch unit falls behind."""
SUMS = ("vadd", "vsub", "vmul", "vnmul", "vcvt", "vcvtr")
MACS = ("vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms")
ARITHMETIC = dict.fromkeys(SUMS, 1) | dict.fromkeys(MACS, 3) | {"vdiv": 14, "vsqrt": 14}
"""Cycles of what takes one longer where the next instruction reads its result."""
CORE = {*(f"r{i}" for i in range(13)), "ip", "lr", "sl", "fp", "sp"}


class Lines(NamedTuple):
    """Properties of every instruction of an image that the rules need: (N,) each.

    Attributes
    ----------
    divides : whether it is a division or a root
    asks : whether it needs the FPU
    memory : whether it loads or stores
    between : whether it has 4 bytes and begins in the middle of a word
    """

    divides: BoolArray
    asks: BoolArray
    memory: BoolArray
    between: BoolArray


def cycles(trace: Trace) -> list[Cycles]:
    """Cycles of each call, its return included; raises Unpublished for what is not in the tables."""
    names = [plain(one) for one in trace.code]
    lines = Lines(
        divides=np.array([name in DIVIDED for name in names]),
        asks=np.array([name.startswith("v") for name in names]),
        memory=np.array([name in WORDS | MANY | {"ldrd", "strd"} for name in names]),
        between=np.array([_between_words(one) for one in trace.code]),
    )
    return [_summed(trace.code, lines, call) for call in trace.calls]


def _summed(known: list[Executed], lines: Lines, call: IndexArray) -> Cycles:
    # What one takes depends on the one before and the one behind it, so equal triples are looked at once.
    base = len(known) + 1
    keys = (np.r_[base - 1, call[:-1]] * base + call) * base + np.r_[call[1:], base - 1]
    triples, which = np.unique(keys, return_inverse=True)
    spans = []
    for key in triples.tolist():
        before, one, after = key // base // base, key // base % base, key % base
        spans.append(
            _cycles(
                known[before] if before < base - 1 else None,
                known[one],
                known[after] if after < base - 1 else None,
            )
        )
    low, high = np.array(spans, dtype=np.intp).reshape(-1, 2)[which].T
    late = _fetches(lines, call, high > low)
    return Cycles(int(low.sum()) - _hidden(lines, call, low, high), int(high.sum()) + late)


def _hidden(lines: Lines, call: IndexArray, low: IndexArray, high: IndexArray) -> int:
    """Cycles of divisions behind which integer instructions may hide, until the FPU is asked again."""
    at = np.flatnonzero(lines.divides[call])
    later = np.r_[np.flatnonzero(lines.asks[call]), len(call)]
    next_asked = later[np.searchsorted(later, at, side="right")]
    ran = np.r_[0, np.cumsum(high)]
    return int(np.minimum(ran[next_asked] - ran[at + 1], low[at] - 1).sum())


def _fetches(lines: Lines, call: IndexArray, wide: BoolArray) -> int:
    """Cycles at most that the fetch unit falls behind in groups of 4 bytes that begin between words.

    One for each stretch of a group that is all loads and stores or has none, unless the span of one of its
    instructions is ``wide`` (N,) already: a load that does not overlap is the same wait.
    """
    between, memory = lines.between[call], lines.memory[call]
    edges = np.flatnonzero(np.diff(np.r_[False, between, False].astype(np.int8))).reshape(-1, 2)
    found = 0
    for start, end in edges[edges[:, 1] - edges[:, 0] >= A_GROUP].tolist():
        changes = 1 + np.flatnonzero(np.diff(memory[start:end].astype(np.int8)))
        found += sum(not stretch.any() for stretch in np.split(wide[start:end], changes))
    return found


def _cycles(before: Executed | None, one: Executed, after: Executed | None) -> Cycles:
    span = _executed(before, one, after)
    return Cycles(min(span.low, 1), span.high) if one.conditional else span


def _executed(before: Executed | None, one: Executed, after: Executed | None) -> Cycles:
    name = plain(one)
    refill = _refill(one, after)
    if name in ("tbb", "tbh"):  # two for the load, one for the sum, three for the pipeline
        return Cycles(6, 6 + _at_most_between(after))
    if name == "nop" or re.fullmatch("it[te]{0,3}", name):
        return Cycles(0 if _narrow(before) else 1, 1)
    if name in WORDS:
        span = _word(before, one, after)
        return Cycles(span.low + refill.low, span.high + refill.high)
    if name in MANY:
        words = 1 + listed(one)
        return Cycles(words + refill.low, words + refill.high)
    if name in ("ldrd", "strd"):
        return Cycles(3, 3)
    if name in ARITHMETIC:
        whole = ARITHMETIC[name] + (after is not None and bool(one.writes & _read(after)))
        return Cycles(whole, whole)
    if name in ("mla", "mls"):  # 2 in the manual's first editions, 1 in its last
        return Cycles(1, 2)
    if name in ("sdiv", "udiv"):
        return Cycles(2, 12)
    if name == "vmov":
        return (Cycles(1, 1), Cycles(1, 2), Cycles(2, 2))[sum(operand in CORE for operand in one.operands)]
    if name in ONE or name in BRANCHES or (name[0] == "b" and len(name) == 3):
        return Cycles(1 + refill.low, 1 + refill.high)
    raise Unpublished(one.name)


def _refill(one: Executed, after: Executed | None) -> Cycles:
    """P, the cycles to refill the pipeline behind a branch; none where execution goes on."""
    if after is not None and after.address == one.following:
        return Cycles(0, 0)
    between = int(after is not None and _between_words(after))
    if plain(one) == "ldr":  # a load of pc takes the manual's three
        return Cycles(3, 3 + _at_most_between(after))
    return Cycles(EARLY + between, LATE + _at_most_between(after))


def _between_words(one: Executed) -> bool:
    """True if an instruction of 4 bytes begins in the middle of a word."""
    return not _narrow(one) and one.address % 4 != 0


def _at_most_between(target: Executed | None) -> int:
    """1 where a branch's target may have to be fetched twice."""
    return int(target is None or _between_words(target))


def _word(before: Executed | None, one: Executed, after: Executed | None) -> Cycles:
    """Cycles of a load or store of one word; one of a double is never pipelined."""
    if one.operands[0][0] == "d":
        return Cycles(3, 3)
    name, address = plain(one), one.registers(of=slice(1, None))
    ours = 2 if "ldr" in name else 1  # STR leaves its data to the cycle of whatever follows
    theirs = ours if name == "ldr" else 2 if name == "vstr" or _is_word(after) else ours
    waits = before is not None and bool(address & before.writes)  # there is no forwarding to an address
    literal = int("pc" in address)
    if before is None or not _is_word(before) or "ldr" not in before.name:
        return Cycles(ours + waits, max(ours, theirs) + waits + literal)
    if waits:  # the address comes out of the load before
        return Cycles(2, 3)
    sure = name[0] != "v" and before.name[0] != "v" and (_narrow(one) or one.address % 4 == 0)
    return Cycles(1, 1 + literal if sure else 2 + literal)


def _is_word(one: Executed | None) -> bool:
    return one is not None and one.name in WORDS and one.operands[0][0] != "d"


def _narrow(one: Executed | None) -> bool:
    """True if an instruction has 2 bytes."""
    return one is not None and one.following - one.address == 2


def _read(one: Executed) -> set[str]:
    """Registers that an instruction of the FPU waits for."""
    first = 0 if not one.writes or ARITHMETIC.get(one.name) == 3 else 1
    return one.registers(of=slice(first, None))


PROCESSOR = cortex_m(
    "-mcpu=cortex-m4",
    "-mfpu=fpv4-sp-d16",
    machine="mps2-an386",
    tick_hz=25_000_000,
    scalars=("float",),
    cpi=(1.0, 3.0),
    basis="one instruction at a time; published at zero wait states: 1 cycle to add, multiply or compare, 2"
    " to load, 3 to multiply and add (TI SWCU192, tables 3-25 and 3-27). Flash wait states come on top",
    goal=1.05,
    cycles=cycles,
)
