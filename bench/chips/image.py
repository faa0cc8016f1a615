"""A kernel linked with the driver for one processor, and the flash and RAM that it takes."""

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

from bench.chips.kernels import Kernel, shapes
from bench.chips.processors import Processor
from bench.chips.toolchain import run, scratch

FIRMWARE = Path(__file__).parent / "firmware"
FLAGS = ("-O2", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections")
"""-O2 is what firmware is commonly built with; functions that nobody calls are left out."""
KERNEL = ("-std=c99",)  # the standard that self-tests and Python's extension are compiled by too
SIZES = ("-fno-asynchronous-unwind-tables", "-Wl,--sort-section=alignment")
"""Leave out tables that only debuggers and C++ read, and gaps in which a few bytes more would vanish."""

DRIVER = ("driver.c", "ports/from_file.c")
_BARE = ("-nostartfiles", "--specs=nosys.specs", f"-T{FIRMWARE / 'ports/mps2.ld'}")
EMPTY = "empty_kernel.elf"
STACK = ("-DBOARD_STACK",)
METHOD = "kernel"
"""Name of an image's only method in its driver."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Image:
    """A linked image, ready to run.

    Attributes
    ----------
    kernel, processor : what was linked, and for which processor
    path : the image's file
    entry : address of the kernel's first instruction
    leave : address of the first instruction after the call
    flash_bytes : by how much the kernel and its libraries enlarge code and constants [bytes]
    ram_static_bytes : by how much they enlarge initialised and zeroed data [bytes]
    """

    kernel: Kernel
    processor: Processor
    path: Path
    entry: int
    leave: int
    flash_bytes: int
    ram_static_bytes: int


def link(kernel: Kernel, processor: Processor, folder: Path, options: tuple[str, ...] = STACK) -> Image:
    """Compile and link into ``folder``; raises ToolError with the compiler's words where that fails.

    ``options`` say how the driver calls the kernel (firmware/call.h).
    """
    sources = kernel.write(folder)
    places = {folder, *((folder / name).parent for name in kernel.sources)}
    includes = [f"-I{place}" for place in sorted(places)]
    of_kernel = kernel.options
    run([*_gcc(processor), *KERNEL, *of_kernel, *includes, "-c", *map(str, sources)], folder)
    objects = [folder / f"{source.stem}.o" for source in sources]
    driver = _driver(processor, options, shapes([kernel]))
    own = {"adapter.c": kernel.adapter, "idle.c": kernel.idle_adapter, "project.c": _project(kernel)}
    for name, text in own.items():
        (folder / name).write_text(text, encoding="utf-8")
    command = [*_gcc(processor), *_bare(processor), *of_kernel, *includes, f"-I{driver}", f"-I{FIRMWARE}"]
    built = folder / "built"
    built.mkdir(exist_ok=True)
    run([*command, *options, "-c", *(str(folder / name) for name in own)], built)
    objects += [driver / f"{Path(name).stem}.o" for name in _sources(processor)]
    objects.append(built / "project.o")
    marks = f"-DMEASURED=measured_{kernel.entry}", f"-DLEFT=left_{kernel.entry}"
    path, empty = folder / "kernel.elf", folder / EMPTY
    for called, asks, elf in ((kernel.entry, "adapter.o", path), ("empty_kernel", "idle.o", empty)):
        call = [*marks, f"-DCALLED={called}", str(FIRMWARE / "call.S")]
        run([*command, str(built / asks), *map(str, objects), *call, "-lm", "-o", str(elf)])
    thumb = int(processor.bare_metal)  # bit 0 of a symbol marks Thumb code and is no part of the address
    symbols, sizes, without = _symbols(processor, path), _sizes(processor, path), _sizes(processor, empty)
    return Image(
        kernel=kernel,
        processor=processor,
        path=path,
        entry=symbols[kernel.entry] & ~thumb,
        leave=symbols[f"left_{kernel.entry}"] & ~thumb,
        flash_bytes=sizes.text + sizes.data - without.text - without.data,
        ram_static_bytes=sizes.data + sizes.zeroed - without.data - without.zeroed,
    )


def _gcc(processor: Processor) -> list[str]:
    return [f"{processor.tools}gcc", *processor.flags, *FLAGS, *SIZES]


def _bare(processor: Processor) -> tuple[str, ...]:
    return (*_BARE, *processor.board) if processor.bare_metal else ()


def _sources(processor: Processor) -> tuple[str, ...]:
    return (*DRIVER, "ports/mps2.c" if processor.bare_metal else "ports/linux.c")


@cache
def _driver(processor: Processor, options: tuple[str, ...], project: str) -> Path:
    """A folder with what is the same for all kernels of one shape, compiled once a process, and project.h."""
    folder = Path(tempfile.mkdtemp(dir=scratch()))
    (folder / "project.h").write_text(project, encoding="utf-8")
    facts = *options, f'-DBOARD_PROCESSOR="{processor.name}"'
    sources = [str(FIRMWARE / name) for name in _sources(processor)]
    run([*_gcc(processor), *_bare(processor), f"-I{folder}", f"-I{FIRMWARE}", *facts, "-c", *sources], folder)
    return folder


def _project(kernel: Kernel) -> str:
    """project.c of one kernel whose demands come from a file, which are asked once and not timed."""
    return f"""\
#include "board.h"

int ask_{kernel.entry}(const scalar *tau, scalar *f);
const struct board_method project_methods[] = {{{{ "{METHOD}", ask_{kernel.entry}, {kernel.levels}, 0, 1 }}}};
const char *const project_facts[] = {{ "-" }};
const uint32_t project_method_count = 1, project_fact_count = 0, project_demands_count = 1;
const uint32_t project_passes = 0;
uint32_t board_stack_bytes;
"""


def without_kernel(image: Image) -> Path:
    """An image like this one whose driver calls a function that returns at once."""
    return image.path.with_name(EMPTY)


def _symbols(processor: Processor, path: Path) -> dict[str, int]:
    rows = (line.split() for line in run([f"{processor.tools}nm", str(path)]).splitlines())
    return {row[2]: int(row[0], 16) for row in rows if len(row) == 3}


def _sizes(processor: Processor, path: Path) -> "_Sizes":
    lines = run([f"{processor.tools}size", str(path)]).splitlines()
    return _Sizes(*(int(number) for number in lines[1].split()[:3]))


class _Sizes(NamedTuple):
    # What the tool "size" prints in its Berkeley form: code and constants, initialised data, zeroed data.
    text: int
    data: int
    zeroed: int
