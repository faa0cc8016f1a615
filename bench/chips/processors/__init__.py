"""Processors, each a file here with its ``PROCESSOR``: how it is compiled for and emulated, its cycles.

A file is its processor's name: ``cortex_m4f.py`` is ``cortex-m4f``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from alloc.errors import unknown
from alloc.files import modules
from alloc.program import Scalar
from bench.chips.boards import boards
from bench.chips.instructions import Cycles, Trace
from bench.record import ProcessorFacts

HOST = ("gcc", "libc6-dev")
"""Debian's packages for the plugin that QEMU loads."""


@dataclass(frozen=True, kw_only=True)
class Processor:
    """A processor, as a compiler and an emulator know it.

    Attributes
    ----------
    name : label in tables and on the command line: the file's
    tools : prefix of the compiler and its companions, e.g. ``arm-none-eabi-``
    flags : the compiler's options for the processor
    emulator : command that runs an image, up to the image's path
    packages : Debian's names of the packages with compiler and emulator
    scalars : precisions that proofs count it in and reports compare methods in: those of its FPU
    cpi : least and most cycles an instruction takes on average over a call
    basis : why these are assumed
    goal : multiple of ``bench.report.sections.emulation.GOALS`` that it may take; None where none were set
    board : options that tell driver and linker of the emulated board; empty under an operating system
    tick_ns : time of a tick of its SysTick [ns]
    callgrind : whether Valgrind counts, in place of QEMU's plugin; the count beside which all others stand
    cycles : cycles of traced calls by published timings; None where nobody published any
    """

    name: str = ""
    tools: str
    flags: tuple[str, ...]
    emulator: tuple[str, ...]
    packages: tuple[str, ...]
    scalars: tuple[Scalar, ...] = ()
    cpi: tuple[float, float] | None = None
    basis: str = ""
    goal: float | None = None
    board: tuple[str, ...] = ()
    tick_ns: float = 0.0
    callgrind: bool = False
    cycles: Callable[[Trace], list[Cycles]] | None = field(default=None, compare=False)

    @property
    def bare_metal(self) -> bool:
        """True if there is no operating system under the image."""
        return bool(self.board)

    @property
    def facts(self) -> ProcessorFacts:
        """Facts for reports: a line of a record."""
        return ProcessorFacts(
            name=self.name,
            scalars=list(self.scalars),
            cpi=list(self.cpi or ()),
            basis=self.basis,
            goal=self.goal,
            microcontroller=self.bare_metal,
            boards=[board.facts for board in boards(self.name)],
        )


def cortex_m(
    *flags: str,
    machine: str,
    tick_hz: int,
    code: int = 0,
    data: int = 0x2000_0000,
    uart: int = 0x4000_4000,
    **known: Any,
) -> Processor:
    """A Cortex-M with its FPU, on one of Arm's MPS2 boards as QEMU has them.

    ``flags`` choose core and FPU. ``code`` and ``data`` are where the board's memory for each begins, at
    least 2 MB; ``uart`` is the address of the serial line that QEMU shows first, ``tick_hz`` what SysTick
    counts [Hz]. ``known`` is the rest of ``Processor``.
    """
    quiet = ("-display", "none", "-monitor", "none", "-serial", "file:line.txt")
    files = ("-semihosting-config", "enable=on,target=native")
    addresses = (f"-Wl,--defsym=CODE={code:#x}", f"-Wl,--defsym=DATA={data:#x}")
    return Processor(
        tools="arm-none-eabi-",
        flags=(*flags, "-mthumb", "-mfloat-abi=hard"),
        emulator=("qemu-system-arm", "-machine", machine, *quiet, *files, "-kernel"),
        packages=("qemu-system-arm", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi", *HOST),
        board=(*addresses, f"-DBOARD_UART={uart:#x}u", f"-DBOARD_TICKS={tick_hz}u"),
        tick_ns=1e9 / tick_hz,
        **known,
    )


def names() -> list[str]:
    """The names of all processors, sorted; imports none."""
    return modules.names(__name__)


def processor(name: str) -> Processor:
    """The processor of that name; raises UnknownName."""
    if name not in names():
        raise unknown("target", name, names())
    found: Processor = modules.module(__name__, name).PROCESSOR
    return replace(found, name=name)


def processors() -> tuple[Processor, ...]:
    """All processors, by name."""
    return tuple(map(processor, names()))
