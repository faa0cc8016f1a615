"""Somebody's allocator as a plug-in: a shared library, or a program with a line protocol."""

import os
from pathlib import Path

MAGIC = (b"\x7fELF", b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe", b"MZ")
"""First bytes of compiled files: of Linux, of macOS (for one processor, for several), of Windows."""
COMMAND = "exec:"
"""Beginning of a method's name that is a command with the line protocol."""


def is_compiled(path: Path) -> bool:
    """True if a file begins as compiled ones do, whatever its name."""
    return _beginning(path).startswith(MAGIC)


def is_library(path: Path) -> bool:
    """True if a file is compiled, and to be loaded."""
    return is_compiled(path) and not is_program(path)


def is_command(name: Path | str) -> bool:
    """True if a method's name is a command with the line protocol."""
    return str(name).startswith(COMMAND)


def runs_apart(name: Path | str) -> bool:
    """True if a method's name is a command or a program's file: another process answers."""
    return is_command(name) or is_program(Path(name))


def is_program(path: Path) -> bool:
    """True if a file is to be run, not loaded: a compiled program, or an executable script but for Python's.

    A compiled program names the loader that starts it, or has a fixed address; a shared library has neither.
    """
    begins = _beginning(path)
    if begins.startswith(b"#!"):
        return path.suffix != ".py" and os.access(path, os.X_OK)
    if begins.startswith(b"\xcf\xfa\xed\xfe"):
        return begins[12] == 2  # Mach-O's MH_EXECUTE
    return begins.startswith(b"\x7fELF") and (_elf_type(begins) == 2 or b"/ld-" in begins)  # ET_EXEC


def _elf_type(begins: bytes) -> int:
    return int.from_bytes(begins[16:18], "big" if begins[5:6] == b"\2" else "little")


def _beginning(path: Path) -> bytes:
    """The first bytes of a file, which hold the headers of a compiled one; none where it can't be read."""
    try:
        with path.open("rb") as file:
            return file.read(4096)
    except OSError:
        return b""
