"""A project builds wherever C compiles, and runs on this computer and in an emulator."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from alloc.program import Scalar
from bench.chips.board.project import write
from bench.chips.board.record import keep
from bench.chips.count import count
from bench.chips.image import link
from bench.record import read
from tests.board_projects import make, project
from tests.emulators import available


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_it_builds_for_posix_with_make_alone_and_warnings_as_errors(
    compiler: str, scalar: Scalar, tmp_path: Path
) -> None:
    write(project(scalar, n=3), tmp_path)
    assert "-Werror" in (tmp_path / "Makefile").read_text()
    make(tmp_path, f"CC={compiler}")
    assert (tmp_path / "build/posix/board").exists()


@pytest.mark.parametrize(("machine", "name"), [("mps2-an386", "cortex-m4f"), ("mps2-an500", "cortex-m7")])
def test_a_log_through_qemu_s_serial_line_has_the_plugin_s_counts(
    machine: str, name: str, tmp_path: Path
) -> None:
    """Two ways: the line, read back; and the image that `emulate` counts, whose demands come from a file."""
    board = available(name)
    scalar: Scalar = "float" if name == "cortex-m4f" else "double"
    asked = project(scalar)
    write(asked, tmp_path)
    make(tmp_path, f"PORT={machine}", "log")
    keep(tmp_path / f"build/{machine}/LOG", tmp_path / "run")
    rows = {(row.method, row.demands): row for row in read(tmp_path / "run").emulated}
    assert len(rows) == 6
    for kernel in asked.kernels:
        folder = tmp_path / kernel.entry
        folder.mkdir()
        image = link(kernel, board, folder)
        for demands in asked.sets:
            counted = count(image, kernel.calls(demands.taus, *demands.limits))
            values, calls = np.unique(counted.instructions, return_counts=True)
            row = rows[kernel.method, demands.name]
            assert row.instructions == list(zip(values.tolist(), calls.tolist(), strict=True))
            assert row.stack_bytes == counted.stack_bytes.max()
            assert row.target == name
            assert row.agrees


def filled_in(folder: Path) -> None:
    """The port for a Cortex-M as a user leaves it, who fills it in and deletes the line that says so."""
    port = folder / "ports/cortex_m.c"
    port.write_text(re.sub(r"#error .*\n", "", port.read_text()))


def test_a_port_that_nobody_filled_in_does_not_build(tmp_path: Path) -> None:
    available("cortex-m4f")
    write(project("float", n=1), tmp_path)
    done = subprocess.run(
        ["make", "-C", tmp_path, "PORT=cortex-m"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode != 0
    assert "fill in what says TO FILL IN, board_put() too, then delete this line" in done.stderr


def test_the_driver_without_kernels_is_small(tmp_path: Path) -> None:
    """At most 8 KiB of flash and 2 KiB of RAM on a Cortex-M, stack included, which -fstack-usage gives."""
    available("cortex-m4f")
    write(project("float", n=1), tmp_path)
    filled_in(tmp_path)
    make(tmp_path, "PORT=cortex-m", "CFLAGS=-O2 -fstack-usage")
    objects = [tmp_path / f"build/cortex-m/{name}.c.o" for name in ("driver", "ports/cortex_m")]
    printed = subprocess.run(["arm-none-eabi-size", *objects], capture_output=True, text=True, check=True)
    sizes = np.array([line.split()[:3] for line in printed.stdout.splitlines()[1:]], dtype=int)
    text, data, zeroed = sizes.sum(axis=0)
    frames = [
        int(line.split("\t")[1])
        for path in tmp_path.rglob("driver*.su")
        for line in path.read_text().splitlines()
    ]
    assert len(frames) > 5
    assert text + data <= 8192
    assert data + zeroed + sum(frames) <= 2048  # as if each function called the next


def test_other_flags_compile_what_was_compiled_with_others(tmp_path: Path) -> None:
    write(project(n=1), tmp_path)
    made = tmp_path / "build/posix/driver.c.o"
    times = []
    for flags in ("CFLAGS=-O1", "CFLAGS=-O1", "CFLAGS=-O0"):
        make(tmp_path, flags)
        times.append(made.stat().st_mtime_ns)
    assert times[0] == times[1] < times[2]


def test_a_main_as_the_page_describes_it_links_with_the_library(tmp_path: Path) -> None:
    available("cortex-m4f")
    write(project("float", n=1), tmp_path)
    filled_in(tmp_path)
    make(tmp_path, "PORT=cortex-m")
    text = '#include "board.h"\nint main(void) { board_start(); return board_run(); }\n'
    (tmp_path / "main.c").write_text(text)
    flags = "-std=c99 -Wall -Wextra -Werror -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16"
    words = f"arm-none-eabi-gcc {flags} --specs=nosys.specs main.c build/cortex-m/board.a -lm -o main.elf"
    done = subprocess.run(words.split(), cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
