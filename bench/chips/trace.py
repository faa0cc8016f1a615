"""Follows calls: from the plugin's addresses and the image's disassembly to what was executed."""

import re
from functools import cache
from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from bench.chips.count import count
from bench.chips.disassembly import lines
from bench.chips.executed import Executed, Trace
from bench.chips.image import Image
from bench.chips.toolchain import run

MOST = 1_000_000
"""Instructions that are traced at most: one call of QOCO's C, none of OSQP's where it gives up."""
_CONDITION = re.compile(r"it[te]{0,3}")


def trace(image: Image, calls: FloatArray, instructions: IndexArray) -> Trace:
    """Instructions of the costliest calls, as many calls as stay below MOST instructions together.

    ``calls`` (N, width) and ``instructions`` (N,) are what ``count`` was given and found.
    """
    known = disassembly(image.path, image.target.tools)
    order = np.argsort(-instructions, kind="stable")
    chosen = order[np.cumsum(instructions[order]) <= MOST]
    if not len(chosen):
        return Trace(known, [])
    path = image.path.with_name("trace.bin")
    count(image, calls[chosen], trace=path.name)
    addresses = np.fromfile(path, "<u4")
    path.unlink()
    ends = np.flatnonzero(addresses == 0xFFFFFFFF)
    parts = [part[:-1] for part in np.split(addresses.astype(np.intp), ends + 1)[:-1]]
    where, code = [one.address for one in known], _code(image)
    executed = [np.searchsorted(where, part[part % 2 == 0]) for part in parts]
    loads = [part[part % 2 == 1] - 1 for part in parts]
    return Trace(known, executed, [part[(code.start <= part) & (part < code.stop)] for part in loads])


def _code(image: Image) -> range:
    """Addresses of code and constants."""
    printed = run([f"{image.target.tools}size", "-A", "-d", str(image.path)])
    sizes = re.findall(r"^\.text +(\d+) +(\d+)", printed, re.M)
    return range(int(sizes[0][1]), int(sizes[0][1]) + int(sizes[0][0]))


@cache
def disassembly(path: Path, tools: str) -> list[Executed]:
    """Every instruction of an image, by address."""
    found, conditional = [], 0
    for one in lines(run([f"{tools}objdump", "-d", "--no-show-raw-insn", str(path)])):
        name, text = one.mnemonic.partition(".")[0], one.operands.partition("<")[0].strip()
        operands = tuple(part.strip() for part in re.split(r",\s*(?![^\[{]*[\]}])", text) if part)
        executed = name[:-2] if conditional else name
        found.append(Executed(one.address, one.following, executed, operands, conditional > 0))
        conditional = len(name) - 1 if _CONDITION.fullmatch(name) else max(0, conditional - 1)
    return sorted(found, key=lambda one: one.address)
