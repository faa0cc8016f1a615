"""The instructions that objdump prints, line by line."""

import re
from itertools import zip_longest
from typing import NamedTuple

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
