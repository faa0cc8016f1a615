"""A binary's instructions in VEX, Valgrind's language: one set of operations for all processors.

pyvex brings the lifter; it is optional, and its library is under the GPL as Valgrind is.
"""

import importlib.util
import struct
from pathlib import Path
from typing import Any

from bench.chips.image import Image

REMEDY = "pip install 'thrustbench[prove]'"
NEEDED = ("archinfo", "pyvex", "z3")
LEAVE = 0x7FFF_F000
"""Where a kernel returns to: no code is there."""
STACK = 0x6000_0000
"""Where the stack begins."""


def missing() -> str:
    """What following a binary lacks and how to get it; empty where nothing is."""
    absent = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    return f"needs {', '.join(absent)}: {REMEDY}" if absent else ""


class Lifted:
    """The code and the constants of an image.

    Attributes
    ----------
    word : bytes of an address
    """

    def __init__(self, image: Image) -> None:
        """Read the image's segments."""
        import archinfo

        self._segments = _segments(image.path)
        self._thumb = image.target.bare_metal
        self._arch: Any = archinfo.ArchARMEL() if self._thumb else archinfo.ArchAArch64()
        self.word = 4 if self._thumb else 8
        self._blocks: dict[int, Any] = {}

    def block(self, at: int) -> Any:
        """The VEX of the instructions from an address to the next jump."""
        import pyvex

        if at not in self._blocks:
            code = self.constants(at, 400)
            odd = int(self._thumb)
            self._blocks[at] = pyvex.lift(
                code, at + odd, self._arch, bytes_offset=odd, max_bytes=len(code), opt_level=1
            )
        return self._blocks[at]

    def address(self, value: int) -> int:
        """The address that a value for the program counter means: bit 0 marks Thumb code."""
        return value & ~1 if self._thumb else value

    def register(self, name: str) -> int:
        """Where VEX keeps a register: r0 and x0 are both ``0``."""
        if name.isdigit():
            name = f"{'r' if self._thumb else 'x'}{name}"
        names = {"sp": "sp" if self._thumb else "xsp", "lr": "lr" if self._thumb else "x30"}
        return int(self._arch.get_register_offset(names.get(name, name)))

    def constants(self, at: int, size: int) -> bytes:
        """Up to so many bytes of the image; empty where it has none at that address."""
        for begin, content in self._segments:
            if begin <= at < begin + len(content):
                return content[at - begin : at - begin + size]
        return b""


def _segments(path: Path) -> list[tuple[int, bytes]]:
    """What the program headers of an ELF file load, and where."""
    data = path.read_bytes()
    wide = data[4] == 2
    start, size, count = (
        (struct.unpack_from("<Q", data, 32)[0], *struct.unpack_from("<HH", data, 54))
        if wide
        else (struct.unpack_from("<I", data, 28)[0], *struct.unpack_from("<HH", data, 42))
    )
    found = []
    for i in range(count):
        at = start + i * size
        if wide:
            kind, _, offset, address, _, length = struct.unpack_from("<IIQQQQ", data, at)
        else:
            kind, offset, address, _, length = struct.unpack_from("<IIIII", data, at)
        if kind == 1:
            found.append((address, data[offset : offset + length]))
    return found
