"""Cycles of the costliest of some calls, as intervals: of the processor, and of boards that have it."""

import re
from functools import cache
from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from bench.chips.boards import Flash, boards, touched, waiting
from bench.chips.count import CallCounts, count
from bench.chips.image import Image
from bench.chips.instructions import Cycles, Executed, Trace, Unpublished, lines
from bench.chips.toolchain import run

MOST = 1_000_000
"""Instructions that are traced at most: one call of QOCO's C, none of OSQP's where it gives up."""
_CONDITION = re.compile(r"it[te]{0,3}")


def trace(image: Image, calls: FloatArray, instructions: IndexArray) -> Trace:
    """Instructions of the costliest calls, as many calls as stay below MOST instructions together.

    ``calls`` (N, width) and ``instructions`` (N,) are what ``count`` was given and found.
    """
    known = disassembly(image.path, image.processor.tools)
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
    printed = run([f"{image.processor.tools}size", "-A", "-d", str(image.path)])
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


TRACED = 20
"""Calls that are followed: those that take most instructions."""


def cycles(image: Image, calls: FloatArray, counted: CallCounts) -> dict[str, Cycles]:
    """At least and at most so many cycles of the costliest call, by whose they are; empty where not known.

    Under the processor's name stand those without wait states, under a board's those with its flash.
    ``calls`` (N, width) are those that were ``counted``. The costliest takes at least what any of them
    takes at least, and at most what any takes at most.
    """
    model = image.processor.cycles
    if model is None:
        return {}
    some = np.argsort(-counted.instructions, kind="stable")[:TRACED]
    followed = trace(image, calls[some], counted.instructions[some])
    try:
        spans = model(followed)
    except Unpublished:
        return {}
    if not spans:
        return {}
    found = {image.processor.name: _costliest(spans)}
    for board in boards(image.processor.name):
        waits = _waits(followed, board.flash)
        behind = [Cycles(s.low + w.low, s.high + w.high) for s, w in zip(spans, waits, strict=True)]
        found[board.name] = _costliest(behind)
    return found


def _costliest(spans: list[Cycles]) -> Cycles:
    return Cycles(max(span.low for span in spans), max(span.high for span in spans))


def _waits(followed: Trace, flash: Flash) -> list[Cycles]:
    """Waits of each call for the flash; calls that took the same path wait alike."""
    known: dict[bytes, Cycles] = {}
    found = []
    for i, call in enumerate(followed.calls):
        key = call.tobytes() + followed.loads[i].tobytes()
        if key not in known:
            known[key] = waiting(flash, *touched(flash, followed.addresses(i), followed.loads[i]))
        found.append(known[key])
    return found
