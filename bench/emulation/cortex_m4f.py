"""Cycles of traced calls on a Cortex-M4F, as an interval: each instruction against Arm's published timing.

Arm's Cortex-M4 technical reference manual (DDI 0439) has a table of instructions (3-1), one of the FPU's
(7-1) and rules for loads and stores (3.3); Texas Instruments reprints them in SWCU192 (tables 3-25 and 3-27)
and SWCU185. They hold at zero wait states. What they leave open makes the interval as wide as it is:

- P, the cycles to refill the pipeline after a branch that is taken: 1 to 3.
- A load or store behind a load takes 1, but boards show 2 where its 4 bytes don't begin at a word. A load of
  a literal may meet the fetch unit: 1 more. Nobody says how the FPU's loads and stores overlap: 1 or 2.
- An instruction whose condition may be false takes its own time or 1. IT and NOP may vanish behind 2 bytes.
- A division or square root takes 14, or less where no instruction of the FPU follows.
- Moving one word between core and FPU is 1 in one print of the table and 2 in the other.
"""

import re

import numpy as np

from alloc import IndexArray
from bench.emulation.interval import Cycles, Unpublished
from bench.emulation.trace import Executed, Trace

P = (1, 3)
"""Cycles to refill the pipeline."""
ONE = {
    *("mov", "movw", "movt", "mvn", "add", "addw", "adc", "adr", "sub", "subw", "sbc", "rsb", "cmp", "cmn"),
    *(
        "tst",
        "teq",
        "and",
        "orr",
        "orn",
        "eor",
        "bic",
        "lsl",
        "lsr",
        "asr",
        "ror",
        "rrx",
        "clz",
        "rbit",
        "rev",
    ),
    *("rev16", "revsh", "uxtb", "uxth", "sxtb", "sxth", "ubfx", "sbfx", "bfi", "bfc", "ssat", "usat", "mul"),
    *("smull", "umull", "smlal", "umlal", "umaal", "uxtab", "uxtah", "pkhbt", "pkhtb"),
    *("neg", "vabs", "vneg", "vcmp", "vcmpe", "vmrs", "vmsr"),
}
"""What takes one cycle; where it writes pc, P more."""
SUMS = ("vadd", "vsub", "vmul", "vnmul", "vcvt", "vcvtr")
MACS = ("vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms")
ARITHMETIC = dict.fromkeys(SUMS, 1) | dict.fromkeys(MACS, 3) | {"vdiv": 14, "vsqrt": 14}
"""Cycles of what takes one longer where the next instruction reads its result."""
WORDS = {"ldr", "ldrb", "ldrh", "ldrsb", "ldrsh", "str", "strb", "strh", "vldr", "vstr"}
MANY = {
    "push",
    "pop",
    "ldm",
    "ldmia",
    "ldmdb",
    "stm",
    "stmia",
    "stmdb",
    "vpush",
    "vpop",
    "vldmia",
    "vldmdb",
    "vstmia",
    "vstmdb",
}
BRANCHES = {"b", "bl", "bx", "blx", "cbz", "cbnz"}
CORE = {*(f"r{i}" for i in range(13)), "ip", "lr", "sl", "fp", "sp"}


def cortex_m4f(trace: Trace) -> list[Cycles]:
    """Cycles of each call, its return included; raises Unpublished for what is not in the tables."""
    return [_summed(trace.known, call) for call in trace.calls]


def _summed(known: list[Executed], call: IndexArray) -> Cycles:
    # What one takes depends on the one before and the one behind it, so equal triples are looked at once.
    base = len(known) + 1
    keys = (np.r_[base - 1, call[:-1]] * base + call) * base + np.r_[call[1:], base - 1]
    low = high = 0
    for key, times in zip(*(part.tolist() for part in np.unique(keys, return_counts=True)), strict=True):
        before, one, after = key // base // base, key // base % base, key % base
        span = _cycles(
            known[before] if before < base - 1 else None,
            known[one],
            known[after] if after < base - 1 else None,
        )
        low, high = low + times * span.low, high + times * span.high
    return Cycles(low, high)


def plain(one: Executed) -> str:
    """The mnemonic without the s that sets flags."""
    return one.name[:-1] if one.name.endswith("s") and one.name[:-1] in ONE else one.name


def _cycles(before: Executed | None, one: Executed, after: Executed | None) -> Cycles:
    span = _executed(before, one, after)
    return Cycles(min(span.low, 1), span.high) if one.conditional else span


def _executed(before: Executed | None, one: Executed, after: Executed | None) -> Cycles:
    name = plain(one)
    refill = Cycles(*P) if after is None or after.address != one.following else Cycles(0, 0)
    if name in ("tbb", "tbh"):
        return Cycles(2 + P[0], 6)
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
        whole = ARITHMETIC[name] + (after is not None and bool(one.written & _read(after)))
        return Cycles(1 if name in ("vdiv", "vsqrt") else whole, whole)
    if name in ("mla", "mls"):
        return Cycles(2, 2)
    if name in ("sdiv", "udiv"):
        return Cycles(2, 12)
    if name == "vmov":
        return (Cycles(1, 1), Cycles(1, 2), Cycles(2, 2))[sum(operand in CORE for operand in one.operands)]
    if name in ONE or name in BRANCHES or (name[0] == "b" and len(name) == 3):
        return Cycles(1 + refill.low, 1 + refill.high)
    raise Unpublished(one.name)


def _word(before: Executed | None, one: Executed, after: Executed | None) -> Cycles:
    """Cycles of a load or store of one word; one of a double is never pipelined."""
    if one.operands[0][0] == "d":
        return Cycles(3, 3)
    name, address = plain(one), one.registers(of=slice(1, None))
    ours = 2 if "ldr" in name else 1  # STR leaves its data to the cycle of whatever follows
    theirs = ours if name == "ldr" else 2 if name == "vstr" or _is_word(after) else ours
    waits = before is not None and bool(address & before.written)  # there is no forwarding to an address
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
    """Whether an instruction has 2 bytes."""
    return one is not None and one.following - one.address == 2


def _read(one: Executed) -> set[str]:
    """Registers that an instruction of the FPU waits for."""
    first = 0 if not one.written or ARITHMETIC.get(one.name) == 3 else 1
    return one.registers(of=slice(first, None))


def listed(one: Executed) -> int:
    """How many words a register list holds: {r4-r7, lr} holds 5, {d8-d9} 4."""
    listed = re.findall(r"([a-z]+)(\d*)(?:-[a-z](\d+))?", one.operands[-1])
    return sum(
        (int(last) - int(first) + 1 if last else 1) * (2 if kind == "d" else 1)
        for kind, first, last in listed
    )
