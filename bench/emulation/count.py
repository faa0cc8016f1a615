"""Run an image over demands and count: instructions of each call exactly, answers, stack."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from alloc import FloatArray, IndexArray
from bench.emulation.image import FIRMWARE, Image, without_kernel
from bench.emulation.kernel import SCALARS
from bench.emulation.toolchain import X86, ToolError, run
from bench.harness.callgrind import CALLGRIND, totals

SYSTICK_NS = 40
"""Both boards clock SysTick at 25 MHz; under ``-icount shift=0`` an instruction takes 1 ns in QEMU."""

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
    """

    F: FloatArray
    status: IndexArray
    instructions: IndexArray
    stack_bytes: IndexArray


def count(image: Image, calls: FloatArray) -> CallCounts:
    """Count calls (N, width), each a demand with its limits where the kernel takes them, in this order."""
    folder = image.path.parent
    if image.target == X86:
        answers = _answers(image, image.path, calls, 1, _callgrind(image))
        instructions = np.array(totals(folder / PROFILE), dtype=np.intp)
    else:
        answers = _answers(image, image.path, calls, 1, _plugged(image))
        instructions = np.loadtxt(folder / "counts.txt", dtype=np.intp, ndmin=1)
    if len(instructions) != len(calls):
        raise ToolError(f"{image.target.name}: {len(instructions)} calls counted, {len(calls)} made")
    return CallCounts(
        answers["f"].astype(np.float64),
        answers["status"].astype(np.intp),
        instructions,
        answers["stack"].astype(np.intp),
    )


def count_by_systick(image: Image, taus: FloatArray, repeats: int = 1000) -> FloatArray:
    """Instructions of each call (N,), counted in a second way: by a board's timer under ``-icount shift=0``.

    Each demand is answered ``repeats`` times. The driver's own instructions are measured with an empty
    kernel of one instruction, and subtracted. Exact up to a tick (40 instructions) over ``repeats``.
    """
    machine, kernel = image.target.emulator[:-1], image.target.emulator[-1]
    counted = (*machine, "-icount", "shift=0", kernel)
    with_kernel = _answers(image, image.path, taus, repeats, counted)["ticks"]
    without = _answers(image, without_kernel(image), taus, repeats, counted)["ticks"]
    difference: FloatArray = (with_kernel - without) * (SYSTICK_NS / repeats) + 1.0
    return difference


def _answers(
    image: Image, path: Path, taus: FloatArray, repeats: int, command: tuple[str, ...]
) -> NDArray[np.void]:
    folder, kernel = image.path.parent, image.kernel
    scalar = np.dtype(SCALARS[kernel.scalar])
    head = np.array([len(taus), repeats], dtype="<i4")
    (folder / "demands.bin").write_bytes(head.tobytes() + taus.astype(scalar).tobytes())
    run([*command, str(path)], folder)
    layout = np.dtype([("f", scalar, (kernel.n,)), ("status", "<i4"), ("stack", "<i4"), ("ticks", "<i4")])
    return np.fromfile(folder / "answers.bin", dtype=layout)


def _plugged(image: Image) -> tuple[str, ...]:
    plugin = image.path.with_name("count.so")
    if not plugin.exists():
        # QEMU asks which version of its interface is meant; the functions used here are the same in each.
        version = re.search(r"version (\d+)", run([image.target.emulator[0], "--version"]))
        api = 1 if version and int(version[1]) < 9 else 2
        run(["gcc", "-O2", "-shared", "-fPIC", f"-DAPI={api}", str(FIRMWARE / "count.c"), "-o", str(plugin)])
    options = f"{plugin},entry={image.entry:#x},leave={image.leave:#x},out=counts.txt"
    emulator, *rest = image.target.emulator
    return (emulator, "-plugin", options, *rest)


def _callgrind(image: Image) -> tuple[str, ...]:
    # Callgrind writes one dump a call: the instructions inside the kernel since the dump before.
    for old in image.path.parent.glob(f"{PROFILE}.*"):
        old.unlink()
    entry = image.kernel.entry
    count_it = (f"--toggle-collect={entry}", f"--dump-after={entry}", f"--callgrind-out-file={PROFILE}")
    return (*CALLGRIND, *count_it)
