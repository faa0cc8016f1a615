"""A kernel linked with the driver for one processor, and what it takes in flash and RAM."""

from dataclasses import dataclass
from pathlib import Path

from bench.emulation.kernel import Kernel
from bench.emulation.toolchain import Target, run

FIRMWARE = Path(__file__).parent / "firmware"
FLAGS = ("-std=gnu11", "-O2", "-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections")
"""-O2 is what firmware is commonly built with; gnu11 lets a multiplication and an addition be fused."""
SIZES = ("-fno-asynchronous-unwind-tables", "-Wl,--sort-section=alignment")
"""No tables that only debuggers and C++ read, and no gaps that a few bytes more could vanish in."""


@dataclass(frozen=True, eq=False)
class Image:
    """A linked image, ready to run.

    Attributes
    ----------
    entry : address of the kernel's first instruction
    leave : address of the first instruction after the call
    flash_bytes : how much larger code and constants are than without the kernel, its libraries included
    ram_static_bytes : the same of initialised and zeroed data
    """

    kernel: Kernel
    target: Target
    path: Path
    entry: int
    leave: int
    flash_bytes: int
    ram_static_bytes: int


def link(kernel: Kernel, target: Target, folder: Path) -> Image:
    """Compile and link into ``folder``; raises ToolError with the compiler's words where it can't be."""
    sources = kernel.write(folder)
    path = _link(kernel, target, folder, sources, kernel.entry)
    symbols = _symbols(target, path)
    text, data, zeroed = _sizes(target, path)
    empty = _sizes(target, _link(kernel, target, folder, sources, "empty_kernel"))
    return Image(
        kernel,
        target,
        path,
        entry=symbols[kernel.entry] & ~target.bare_metal,  # bit 0 only says that it is Thumb code
        leave=symbols["kernel_left"] & ~target.bare_metal,
        flash_bytes=text + data - empty[0] - empty[1],
        ram_static_bytes=data + zeroed - empty[1] - empty[2],
    )


def without_kernel(image: Image) -> Path:
    """The same image with the driver calling a function that returns at once."""
    return image.path.with_name("empty_kernel.elf")


def _link(kernel: Kernel, target: Target, folder: Path, sources: list[Path], called: str) -> Path:
    path = folder / f"{called}.elf"
    driver = [FIRMWARE / "measure.c", FIRMWARE / "call.S"]
    bare = [FIRMWARE / "startup.c", "--specs=rdimon.specs", "-nostartfiles", "-T", FIRMWARE / "cortex-m.ld"]
    includes = {folder, *(source.parent for source in (folder / name for name in kernel.sources))}
    command = [
        f"{target.tools}gcc",
        *target.flags,
        *FLAGS,
        *SIZES,
        f"-DCALLED={called}",
        *(f"-I{place}" for place in sorted(includes)),
        *sources,
        *driver,
        *(bare if target.bare_metal else ()),
        "-lm",
        "-o",
        path,
    ]
    run([str(part) for part in command])
    return path


def _symbols(target: Target, path: Path) -> dict[str, int]:
    rows = (line.split() for line in run([f"{target.tools}nm", str(path)]).splitlines())
    return {row[2]: int(row[0], 16) for row in rows if len(row) == 3}


def _sizes(target: Target, path: Path) -> tuple[int, int, int]:
    # "size" in its Berkeley form: text (with constants), data, bss.
    text, data, zeroed = run([f"{target.tools}size", str(path)]).splitlines()[1].split()[:3]
    return int(text), int(data), int(zeroed)
