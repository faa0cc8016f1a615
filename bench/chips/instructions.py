"""Instructions as objdump prints them and as calls executed them: the input of tables of cycles."""

import re
from dataclasses import dataclass, field
from functools import cached_property
from itertools import zip_longest
from typing import NamedTuple

import numpy as np

from alloc.allocation import IndexArray


class Cycles(NamedTuple):
    """At least and at most so many cycles."""

    low: int
    high: int


class Unpublished(Exception):
    """Nobody has published what this takes."""


LINE = re.compile(r"^ *([0-9a-f]+):\t(?:(?:notrack|bnd|repz) )?(\S+)(?:\s+(.*))?$")
NAME = re.compile(r"^[0-9a-f]+ <([^>]+)>:$")
COMMENT = re.compile(r"\s*[@;/].*")


class Disassembled(NamedTuple):
    """An instruction, or data between instructions: a directive as ``.word``.

    Attributes
    ----------
    address, following : where it lies, and the next line; -1 behind the last one
    function : the function it stands in
    mnemonic, operands : as printed, without comments and prefixes
    last : whether data or another function stand behind it
    """

    address: int
    following: int
    function: str
    mnemonic: str
    operands: str
    last: bool


def lines(printed: str) -> list[Disassembled]:
    """The lines of ``objdump -d --no-show-raw-insn``, in its order."""
    found: list[tuple[int, str, str, str]] = []
    function = ""
    for line in printed.splitlines():
        if named := NAME.match(line):
            function = named[1]
        elif said := LINE.match(line):
            found.append((int(said[1], 16), function, said[2], COMMENT.sub("", said[3] or "").strip()))
    return [
        Disassembled(
            address, after[0], function, mnemonic, operands, after[1] != function or after[2][0] == "."
        )
        for (address, function, mnemonic, operands), after in zip_longest(
            found, found[1:], fillvalue=(-1, "", ".", "")
        )
    ]


_REGISTER = re.compile(r"\b(?:[rsd]\d+|sp|lr|pc|ip|fp|sl)\b")
_READ_FIRST = (
    *("str", "vstr", "stm", "vstm", "cmp", "cmn", "tst", "teq", "vcmp", "b", "cb", "tb", "push", "vpush"),
)
"""Mnemonics that read their first operand and write none."""


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
    def writes(self) -> set[str]:
        """The register that it writes; empty where its first operand is read."""
        reads = self.name.startswith(_READ_FIRST) and not self.name.startswith(("bic", "bfi", "bfc"))
        return set() if reads else self.registers(of=slice(1))


@dataclass(frozen=True, eq=False)
class Trace:
    """Instructions that calls executed.

    Attributes
    ----------
    code : every instruction of the image
    calls : for each call the indices in ``code`` of what it executed, in order
    loads : for each call the addresses of the words that it read where code lies, in order
    """

    code: list[Executed]
    calls: list[IndexArray]
    loads: list[IndexArray] = field(default_factory=list)

    def addresses(self, call: int) -> IndexArray:
        """Addresses of the instructions that a call executed, in order."""
        places: IndexArray = np.array([one.address for one in self.code])[self.calls[call]]
        return places


ONE = {
    *("mov", "movw", "movt", "mvn", "add", "addw", "adc", "adr", "sub", "subw", "sbc", "rsb", "cmp", "cmn"),
    *("tst", "teq", "and", "orr", "orn", "eor", "bic", "lsl", "lsr", "asr", "ror", "rrx", "clz", "rbit"),
    *("rev", "rev16", "revsh", "uxtb", "uxth", "sxtb", "sxth", "ubfx", "sbfx", "bfi", "bfc", "ssat", "usat"),
    *("mul", "smull", "umull", "smlal", "umlal", "umaal", "smulbb", "smlabb"),
    *("uxtab", "uxtah", "pkhbt", "pkhtb"),
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
    """Number of words of a register list: {r4-r7, lr} holds 5, {d8-d9} 4."""
    listed = re.findall(r"([a-z]+)(\d*)(?:-[a-z](\d+))?", one.operands[-1])
    return sum(
        (int(last) - int(first) + 1 if last else 1) * (2 if kind == "d" else 1)
        for kind, first, last in listed
    )
