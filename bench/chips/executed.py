"""Instructions, which of them calls executed, and their kinds in Thumb: the input of tables of cycles."""

import re
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from alloc.allocation import IndexArray

_REGISTER = re.compile(r"\b(?:[rsd]\d+|sp|lr|pc|ip|fp|sl)\b")
_READ_FIRST = (
    *("str", "vstr", "stm", "vstm", "cmp", "cmn", "tst", "teq", "vcmp", "b", "cb", "tb", "push", "vpush"),
)
"""What reads its first operand and writes none."""


@dataclass(frozen=True)
class Executed:
    """One line of a disassembly.

    Attributes
    ----------
    address : where it lies
    following : address of the next one, where execution goes on unless it branches
    name : mnemonic without its type, its width and a condition out of an IT block: ``vadd``, ``bls``
    operands : as the disassembly has them
    conditional : whether it stands in an IT block, so that it may do nothing
    """

    address: int
    following: int
    name: str
    operands: tuple[str, ...]
    conditional: bool

    def registers(self, *, of: slice = slice(None)) -> set[str]:
        """Registers in some of the operands, by name."""
        return set(_REGISTER.findall(" ".join(self.operands[of])))

    @cached_property
    def written(self) -> set[str]:
        """The register that it writes; empty where its first operand is read."""
        reads = self.name.startswith(_READ_FIRST) and not self.name.startswith(("bic", "bfi", "bfc"))
        return set() if reads else self.registers(of=slice(1))


@dataclass(frozen=True, eq=False)
class Trace:
    """Instructions that calls executed.

    Attributes
    ----------
    known : every instruction of the image
    calls : for each call the indices in ``known`` of what it executed, in order
    loads : for each call the addresses of the words that it read where code lies, in order
    """

    known: list[Executed]
    calls: list[IndexArray]
    loads: list[IndexArray] = field(default_factory=list)

    def addresses(self, call: int) -> IndexArray:
        """Addresses of the instructions that a call executed, in order."""
        places: IndexArray = np.array([one.address for one in self.known])[self.calls[call]]
        return places


ONE = {
    *("mov", "movw", "movt", "mvn", "add", "addw", "adc", "adr", "sub", "subw", "sbc", "rsb", "cmp", "cmn"),
    *("tst", "teq", "and", "orr", "orn", "eor", "bic", "lsl", "lsr", "asr", "ror", "rrx", "clz", "rbit"),
    *("rev", "rev16", "revsh", "uxtb", "uxth", "sxtb", "sxth", "ubfx", "sbfx", "bfi", "bfc", "ssat", "usat"),
    *("mul", "smull", "umull", "smlal", "umlal", "umaal", "uxtab", "uxtah", "pkhbt", "pkhtb"),
    *("neg", "vabs", "vneg", "vcmp", "vcmpe", "vmrs", "vmsr"),
}
"""Instructions that take one cycle; P more where they write pc."""
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
