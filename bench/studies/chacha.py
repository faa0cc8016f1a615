"""Our interval of cycles beside two boards': ``python -m bench.studies.chacha FOLDER``, docs/embedded.md.

FOLDER is a copy of github.com/joostrijneveld/chacha-arm-cortex-m, which prints the cycles of one ChaCha
permutation at zero wait states. Its assembly has no branch, so what it executes is what it lists. Where the
linker put it is not said: all instructions but the last few have 4 bytes, so all begin at words, or none.
"""

import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.chips.cortex_m4f import cortex_m4f
from bench.chips.toolchain import run, target
from bench.chips.trace import Trace, disassembly
from bench.results.text import table

MEASURED = {8: (390, 414), 12: (542, 572), 20: (846, 888)}
"""Cycles by rounds, as its README has them: STM32L100 (a Cortex-M3, whose table is the same), STM32F407."""
AROUND = (4, 8)
"""Cycles for the call, its arguments and one reading of the clock, at least and at most."""


def intervals(folder: Path, rounds: int) -> list[tuple[int, int]]:
    """Cycles of a permutation that begins at a word, and of one that begins between two."""
    text = run([sys.executable, str(folder / "common/chacha_gen.py"), str(rounds)])
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "chacha.o"
        tools = target("cortex-m4f").tools
        subprocess.run([f"{tools}as", "-mthumb", "-", "-o", path], input=text, text=True, check=True)
        known = disassembly(path, tools)
    found = []
    for shift in (0, 2):
        moved = [replace(one, address=one.address + shift, following=one.following + shift) for one in known]
        (span,) = cortex_m4f(Trace(moved, [np.arange(len(moved))]))
        found.append((span.low + AROUND[0], span.high + AROUND[1]))
    return found


def main(folder: str) -> None:
    """Print a line for each number of rounds, hit or miss."""
    lines = []
    for rounds, boards in MEASURED.items():
        cells = []
        for low, high in intervals(Path(folder), rounds):
            said = ("inside" if low <= one <= high else "outside" for one in boards)
            cells += [f"{low} to {high}", *said]
        lines.append([str(rounds), *map(str, boards), *cells])
    ends = ("M3", "M4F")
    print(table(("rounds", *ends, "at a word", *ends, "between words", *ends), lines))


if __name__ == "__main__":
    main(*sys.argv[1:])
