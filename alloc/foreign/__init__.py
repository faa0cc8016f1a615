"""Somebody's compiled allocator as a plug-in: its C interface, and the way from Python to it."""

from pathlib import Path

MAGIC = (b"\x7fELF", b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe", b"MZ")
"""First bytes of compiled files: of Linux, of macOS (for one processor, for several), of Windows."""


def is_compiled(path: Path) -> bool:
    """True if a file begins as compiled ones do, whatever its name."""
    try:
        with path.open("rb") as file:
            return file.read(4).startswith(MAGIC)
    except OSError:
        return False
