"""Times of a C function in a C loop, and its instructions call by call, both without Python."""

import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from alloc.allocation import FloatArray
from alloc.c.compiled import STANDARD, compiler
from bench.chips.kernels import SCALARS, Kernel
from bench.harness.timing import CALLGRIND, instruction_totals

LOOP = Path(__file__).with_name("loop.c")
REPEAT_NS = 2e6
"""Length of one repeat: long against the clock's 20 ns, short against a time slice."""


@contextmanager
def program(kernel: Kernel, taus: FloatArray) -> Iterator[list[str]]:
    """The compiled loop around the kernel, as a command to which ROUNDS and REPEATS must be added."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        units = kernel.write(folder)
        (folder / "kernel.h").write_text(_header(kernel), encoding="utf-8")
        includes = sorted({f"-I{path.parent}" for path in folder.rglob("*.h")})
        made, demands = folder / "loop", folder / "demands.bin"
        np.ascontiguousarray(taus, dtype=SCALARS[kernel.scalar]).tofile(demands)
        sources = [str(path) for path in (*units, LOOP)]
        # The loop is in a file of its own, so that no kernel is inlined into it.
        subprocess.run(
            [*compiler(), *STANDARD, "-O2", "-w", *includes, *sources, "-lm", "-o", str(made)], check=True
        )
        yield [str(made), str(demands)]


def _header(kernel: Kernel) -> str:
    """Facts of a kernel that the loop must know; behind tau lie f_min and f_max."""
    places = {"f_min": f"tau + {kernel.k}", "f_max": f"tau + {kernel.k + kernel.n}"}
    arguments = re.sub("f_min|f_max", lambda name: places[name[0]], kernel.arguments)
    shares = f"static {kernel.scalar} share[{kernel.levels}];\n" if kernel.levels else ""
    return (
        f"{kernel.declaration}\n{shares}"
        f"#define SCALAR {kernel.scalar}\n"
        f"#define WIDTH {kernel.width}\n"
        f"#define N {kernel.n}\n"
        f"#define ANSWER(tau, f) {kernel.entry}({arguments})\n"
    )


def nanoseconds(kernel: Kernel, taus: FloatArray, repeats: int = 15) -> FloatArray:
    """Time per call [ns], one number for each repeat over all ``taus`` (N, k)."""
    with program(kernel, taus) as command:
        once = _run([*command, "1", "3"])
        rounds = max(1, round(REPEAT_NS / (float(np.min(once)) * len(taus))))
        return _run([*command, str(rounds), str(repeats)])


def instructions(kernel: Kernel, taus: FloatArray) -> NDArray[np.int64]:
    """Instructions (N,) of each call, counted by callgrind from the function's entry to its return."""
    with program(kernel, taus) as command, tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "counts"
        options = [f"--toggle-collect={kernel.entry}", f"--dump-after={kernel.entry}"]
        counted = [*CALLGRIND, f"--callgrind-out-file={out}", *options, *command, "0", "0"]
        subprocess.run(counted, check=True, capture_output=True)
        return np.array(instruction_totals(out)[: len(taus)], dtype=np.int64)


def _run(command: list[str]) -> FloatArray:
    environment = os.environ | {"LC_ALL": "C"}
    out = subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout
    return np.array(out.split(), dtype=float)
