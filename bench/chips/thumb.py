"""Thumb instructions by kind, as both tables of cycles ask for them."""

import re

from bench.chips.executed import Executed

ONE = {
    *("mov", "movw", "movt", "mvn", "add", "addw", "adc", "adr", "sub", "subw", "sbc", "rsb", "cmp", "cmn"),
    *("tst", "teq", "and", "orr", "orn", "eor", "bic", "lsl", "lsr", "asr", "ror", "rrx", "clz", "rbit"),
    *("rev", "rev16", "revsh", "uxtb", "uxth", "sxtb", "sxth", "ubfx", "sbfx", "bfi", "bfc", "ssat", "usat"),
    *("mul", "smull", "umull", "smlal", "umlal", "umaal", "uxtab", "uxtah", "pkhbt", "pkhtb"),
    *("neg", "vabs", "vneg", "vcmp", "vcmpe", "vmrs", "vmsr"),
}
"""What takes one cycle; where it writes pc, P more."""
WORDS = {"ldr", "ldrb", "ldrh", "ldrsb", "ldrsh", "str", "strb", "strh", "vldr", "vstr"}
MANY = {
    *("push", "pop", "ldm", "ldmia", "ldmdb", "stm", "stmia", "stmdb"),
    *("vpush", "vpop", "vldmia", "vldmdb", "vstmia", "vstmdb"),
}
BRANCHES = {"b", "bl", "bx", "blx", "cbz", "cbnz"}


def plain(one: Executed) -> str:
    """The mnemonic without the s that sets flags."""
    return one.name[:-1] if one.name.endswith("s") and one.name[:-1] in ONE else one.name


def listed(one: Executed) -> int:
    """How many words a register list holds: {r4-r7, lr} holds 5, {d8-d9} 4."""
    listed = re.findall(r"([a-z]+)(\d*)(?:-[a-z](\d+))?", one.operands[-1])
    return sum(
        (int(last) - int(first) + 1 if last else 1) * (2 if kind == "d" else 1)
        for kind, first, last in listed
    )
