"""Instruction counts by valgrind's callgrind: its command line and its profiles."""

from pathlib import Path

CALLGRIND = ("valgrind", "--vgdb=no", "--tool=callgrind")
"""Valgrind waits for no debugger (vgdb), whose pipes would stay in the temporary folder after a kill."""


def totals(out: Path) -> list[int]:
    """Instructions in each profile that callgrind dumped on the way, in order.

    They are called ``out.1``, ``out.2``, …, where ``out`` is what it was given as ``--callgrind-out-file``.
    """
    profiles = sorted(out.parent.glob(f"{out.name}.*"), key=lambda path: int(path.suffix[1:]))
    lines = (line for path in profiles for line in path.read_text(encoding="utf-8").splitlines())
    return [int(line.split()[1]) for line in lines if line.startswith("totals:")]
