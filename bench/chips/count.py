"""Run an image over demands and count: instructions of each call exactly, answers, stack."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from bench.chips.image import FIRMWARE, METHOD, Image, link, without_kernel
from bench.chips.kernels import SCALARS
from bench.chips.toolchain import ToolError, run, scratch
from bench.harness.timing import CALLGRIND, instruction_totals
from bench.inputs.board_log import answered, parse

REPEATS = 1000
ROOM = 1 << 20
"""Bytes of demands that an image has room for (firmware/ports/from_file.c)."""

LINE = "line.txt"
"""Name of the file that holds what an image printed."""
PROFILE = "callgrind"
"""Name of the file that callgrind writes at the end, and of those on the way, which have a number."""


@dataclass(frozen=True, eq=False)
class CallCounts:
    """Answers and costs of N calls.

    Attributes
    ----------
    F : (N, n) thrusts as the kernel left them [N]
    status : (N,) what the kernel returned
    instructions : (N,) executed from the kernel's first instruction to its return, callees included
    stack_bytes : (N,) stack below the caller's that was written to [bytes]
    shares : (N, levels) what the kernel says that it delivered of each level [-]
    """

    F: FloatArray
    status: IndexArray
    instructions: IndexArray
    stack_bytes: IndexArray
    shares: FloatArray


def count(image: Image, calls: FloatArray, trace: str = "") -> CallCounts:
    """Count calls (N, width), each a demand with its limits where the kernel takes them, in this order.

    ``trace`` names a file beside the image for the addresses of all instructions (firmware/count.c).
    """
    most = max(1, ROOM // (image.kernel.width * np.dtype(SCALARS[image.kernel.scalar]).itemsize))
    parts = [_count(image, calls[start : start + most], trace) for start in range(0, len(calls), most)]
    columns = zip(*((c.F, c.status, c.instructions, c.stack_bytes, c.shares) for c in parts), strict=True)
    return CallCounts(*(np.concatenate(column) for column in columns))


def _count(image: Image, calls: FloatArray, trace: str) -> CallCounts:
    if not image.processor.callgrind:
        return _answers(image, image.path, calls, _plugged(image, trace))
    counted = _answers(image, image.path, calls, _callgrind(image))
    instructions = np.array(instruction_totals(image.path.parent / PROFILE), dtype=np.intp)
    if len(instructions) != len(calls):
        raise ToolError(f"{image.processor.name}: {len(instructions)} calls counted, {len(calls)} made")
    return replace(counted, instructions=instructions)


def count_by_systick(image: Image, taus: FloatArray) -> FloatArray:
    """Instructions of each call (N,), counted in a second way: by a board's timer under ``-icount shift=0``.

    Each demand is answered REPEATS times. The driver's own instructions are measured with an empty
    kernel of one instruction, and subtracted. Exact up to a tick over REPEATS: QEMU takes 1 ns
    for an instruction under ``-icount shift=0``.
    """
    options = (f"-DBOARD_REPEATS={REPEATS}", "-DBOARD_SYSTICK")
    folder = image.path.parent / "systick"
    folder.mkdir(exist_ok=True)
    timed = link(image.kernel, image.processor, folder, options)
    emulator, *rest = image.processor.emulator
    command = (emulator, "-icount", "shift=0", *rest)
    with_kernel = _answers(timed, timed.path, taus, command).instructions
    without = _answers(timed, without_kernel(timed), taus, command).instructions
    ns = (with_kernel - without) * image.processor.tick_ns
    difference: FloatArray = ns / REPEATS + 1.0
    return difference


def _answers(image: Image, path: Path, calls: FloatArray, command: Sequence[str]) -> CallCounts:
    """Answers that the driver printed for each call, ticks as instructions."""
    folder, kernel = path.parent, image.kernel
    scalar = np.dtype(SCALARS[kernel.scalar])
    head = np.array([len(calls)], dtype="<i4")
    (folder / "demands.bin").write_bytes(head.tobytes() + calls.astype(scalar).tobytes())
    printed = run([*command, str(path)], folder)
    if image.processor.bare_metal:
        printed = (folder / LINE).read_text(encoding="ascii", errors="replace")
    log = parse(printed.encode())
    asked = [block for block in log.blocks if block.kind == "ask" and block.words[0] == METHOD]
    if len(asked) != 1 or len(asked[0].texts("f")) != len(calls):
        said = "; ".join(log.nonsense) or "the driver did not answer each call"
        raise ToolError(f"{image.processor.name}: {said}")
    found = answered(asked[0], kernel.n, scalar, kernel.levels)
    return CallCounts(found.F, found.status, found.ticks, found.stack_bytes, found.shares)


def _plugged(image: Image, trace: str) -> tuple[str, ...]:
    emulator, *rest = image.processor.emulator
    options = f"{_plugin(emulator)},entry={image.entry:#x},leave={image.leave:#x},ticks=ticks"
    options += f",trace={trace}" if trace else ""
    return (emulator, "-plugin", options, *rest)


@cache
def _plugin(emulator: str) -> Path:
    """QEMU's plugin that counts, compiled once a process for this emulator."""
    plugin = scratch() / f"count-{emulator}.so"
    # QEMU asks which version of its interface is meant; the functions used here are the same in each.
    version = re.search(r"version (\d+)", run([emulator, "--version"]))
    api = 1 if version and int(version[1]) < 9 else 2
    run(["gcc", "-O2", "-shared", "-fPIC", f"-DAPI={api}", str(FIRMWARE / "count.c"), "-o", str(plugin)])
    return plugin


def _callgrind(image: Image) -> tuple[str, ...]:
    # Callgrind writes one dump a call: the instructions inside the kernel since the dump before.
    for old in image.path.parent.glob(f"{PROFILE}.*"):
        old.unlink()
    entry = image.kernel.entry
    count_it = (f"--toggle-collect={entry}", f"--dump-after={entry}", f"--callgrind-out-file={PROFILE}")
    return (*CALLGRIND, *count_it)
