"""A kernel linked with the driver for one processor, and the flash and RAM that it takes."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from bench.chips.kernel import Kernel, shapes
from bench.chips.target import Target
from bench.chips.toolchain import run

FIRMWARE = Path(__file__).parent / "firmware"
FLAGS = ("-O2", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections")
"""-O2 is what firmware is commonly built with; functions that nobody calls are left out."""
KERNEL = ("-std=c99",)  # as generated C is compiled for its self-test and for Python
SIZES = ("-fno-asynchronous-unwind-tables", "-Wl,--sort-section=alignment")
"""Leave out tables that only debuggers and C++ read, and gaps in which a few bytes more would vanish."""

DRIVER = ("driver.c", "ports/from_file.c")
_BARE = ("-nostartfiles", "--specs=nosys.specs", f"-T{FIRMWARE / 'ports/mps2.ld'}")
EMPTY = "empty_kernel.elf"
STACK = ("-DBOARD_STACK",)
METHOD = "kernel"
"""What the driver of an image calls its only method."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Image:
    """A linked image, ready to run.

    Attributes
    ----------
    kernel, target : what was linked, and for which processor
    path : the image's file
    entry : address of the kernel's first instruction
    leave : address of the first instruction after the call
    flash_bytes : by how much the kernel and its libraries enlarge code and constants [bytes]
    ram_static_bytes : by how much they enlarge initialised and zeroed data [bytes]
    """

    kernel: Kernel
    target: Target
    path: Path
    entry: int
    leave: int
    flash_bytes: int
    ram_static_bytes: int


def link(kernel: Kernel, target: Target, folder: Path, options: tuple[str, ...] = STACK) -> Image:
    """Compile and link into ``folder``; raises ToolError with the compiler's words where that fails.

    ``options`` say how the driver calls the kernel (firmware/call.h).
    """
    sources = kernel.write(folder)
    compiler = [f"{target.tools}gcc", *target.flags, *FLAGS, *SIZES]
    places = {folder, *((folder / name).parent for name in kernel.sources)}
    includes = [f"-I{place}" for place in sorted(places)]
    run([*compiler, *KERNEL, *includes, "-c", *(str(source) for source in sources)], folder)
    objects = [str(folder / f"{source.stem}.o") for source in sources]
    port = "ports/mps2.c" if target.bare_metal else "ports/linux.c"
    driver = [str(FIRMWARE / name) for name in (*DRIVER, port)]
    (folder / "project.h").write_text(shapes([kernel]), encoding="utf-8")
    for name, text in (("adapter.c", kernel.adapter), ("project.c", _project(kernel))):
        (folder / name).write_text(text, encoding="utf-8")
        driver.append(str(folder / name))
    marks = f"-DMEASURED=measured_{kernel.entry}", f"-DLEFT=left_{kernel.entry}"
    facts = *options, f'-DBOARD_PROCESSOR="{target.name}"'
    bare = (*_BARE, *target.board) if target.bare_metal else ()
    command = [*compiler, *includes, f"-I{FIRMWARE}", *marks, *facts, *objects, *driver]
    command += [str(FIRMWARE / "call.S"), *bare, "-lm"]
    path, empty = folder / "kernel.elf", folder / EMPTY
    run([*command, f"-DCALLED={kernel.entry}", "-o", str(path)])
    run([*command, "-DCALLED=empty_kernel", "-o", str(empty)])
    thumb = 1 if target.bare_metal else 0  # bit 0 of a symbol marks Thumb code and is no part of the address
    symbols, sizes, without = _symbols(target, path), _sizes(target, path), _sizes(target, empty)
    return Image(
        kernel=kernel,
        target=target,
        path=path,
        entry=symbols[kernel.entry] & ~thumb,
        leave=symbols[f"left_{kernel.entry}"] & ~thumb,
        flash_bytes=sizes.text + sizes.data - without.text - without.data,
        ram_static_bytes=sizes.data + sizes.zeroed - without.data - without.zeroed,
    )


def _project(kernel: Kernel) -> str:
    """project.c of one kernel whose demands come from a file, which are asked once and not timed."""
    return f"""\
#include "board.h"

int ask_{kernel.entry}(const scalar *tau, scalar *f);
const struct board_method project_methods[] = {{{{ "{METHOD}", ask_{kernel.entry}, {kernel.levels} }}}};
const char *const project_facts[] = {{ "-" }};
const uint32_t project_method_count = 1, project_fact_count = 0, project_demands_count = 1;
const uint32_t project_passes = 0;
uint32_t board_stack_bytes;
"""


def without_kernel(image: Image) -> Path:
    """An image like this one whose driver calls a function that returns at once."""
    return image.path.with_name(EMPTY)


def _symbols(target: Target, path: Path) -> dict[str, int]:
    rows = (line.split() for line in run([f"{target.tools}nm", str(path)]).splitlines())
    return {row[2]: int(row[0], 16) for row in rows if len(row) == 3}


def _sizes(target: Target, path: Path) -> "_Sizes":
    lines = run([f"{target.tools}size", str(path)]).splitlines()
    return _Sizes(*(int(number) for number in lines[1].split()[:3]))


class _Sizes(NamedTuple):
    # What the tool "size" prints in its Berkeley form: code and constants, initialised data, zeroed data.
    text: int
    data: int
    zeroed: int
