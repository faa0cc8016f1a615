"""A compiler and an emulator for each processor, and how to get those that are missing."""

import platform
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from alloc import AllocError
from alloc.errors import unknown


class ToolError(AllocError):
    """A compiler or an emulator failed; the message names it and quotes its own."""


@dataclass(frozen=True, kw_only=True)
class Target:
    """A processor, as a compiler and an emulator know it.

    Attributes
    ----------
    name : label in tables and on the command line
    tools : prefix of the compiler and its companions, e.g. ``arm-none-eabi-``
    flags : the compiler's options for the processor
    emulator : command that runs an image, up to the image's path
    packages : Debian's names of the packages with compiler and emulator
    """

    name: str
    tools: str
    flags: tuple[str, ...]
    emulator: tuple[str, ...]
    packages: tuple[str, ...]

    @property
    def bare_metal(self) -> bool:
        """Whether there is no operating system under the image."""
        return self.tools == "arm-none-eabi-"


def _board(machine: str) -> tuple[str, ...]:
    quiet = ("-display", "none", "-monitor", "none", "-serial", "file:line.txt")
    files = ("-semihosting-config", "enable=on,target=native")
    return ("qemu-system-arm", "-machine", machine, *quiet, *files, "-kernel")


_HOST = ("gcc", "libc6-dev")  # compiles the plugin that QEMU loads
_CORTEX_M = ("qemu-system-arm", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi", *_HOST)
_HARD_FLOAT = ("-mthumb", "-mfloat-abi=hard")
TARGETS = (
    Target(
        name="cortex-m7",
        tools="arm-none-eabi-",
        flags=("-mcpu=cortex-m7", "-mfpu=fpv5-d16", *_HARD_FLOAT),
        emulator=_board("mps2-an500"),
        packages=_CORTEX_M,
    ),
    Target(
        name="cortex-m4f",
        tools="arm-none-eabi-",
        flags=("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", *_HARD_FLOAT),
        emulator=_board("mps2-an386"),
        packages=_CORTEX_M,
    ),
    Target(
        name="aarch64",
        tools="aarch64-linux-gnu-",
        # Without the fix for that erratum: the first of its stubs would fill a page.
        flags=("-static", "-mno-fix-cortex-a53-843419"),
        emulator=("qemu-aarch64",),
        packages=("qemu-user", "gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross", *_HOST),
    ),
)
X86 = Target(
    name="x86-64",
    tools="x86_64-linux-gnu-",
    flags=("-static",),
    emulator=("valgrind",),
    packages=("valgrind", *_HOST),
)
"""Callgrind counts on it; the ratio of another target's count to this one says how far it carries."""

TIME_LIMIT_S = 900
"""The longest command takes about a minute: OSQP's C in double precision, where double is software."""


def target(name: str) -> Target:
    """The target of that name; raises UnknownName."""
    for known in (*TARGETS, X86):
        if known.name == name:
            return known
    raise unknown("target", name, (t.name for t in TARGETS))


def missing(target: Target) -> str:
    """What a target lacks and how to get it, in one line; empty where it lacks nothing."""
    if target == X86 and platform.machine() != "x86_64":
        return f"{target.name} needs callgrind on an x86-64 machine: it emulates no other"
    commands = [f"{target.tools}gcc", target.emulator[0], "gcc"]
    absent = [command for command in dict.fromkeys(commands) if not shutil.which(command)]
    if not absent and not _has_c_library(target):
        absent = ["a C library for it"]
    remedy = f"apt-get install {' '.join(target.packages)} (or make emulate)"
    return f"{target.name} needs {', '.join(absent)}: {remedy}" if absent else ""


def versions(target: Target) -> dict[str, str]:
    """Versions of a target's compiler and emulator, by command."""
    printed = {name: run([name, "--version"]) for name in (f"{target.tools}gcc", target.emulator[0])}
    return {name: (re.search(r"\d+\.\d+(\.\d+)?", text) or [""])[0] for name, text in printed.items()}


def run(command: list[str], folder: Path | None = None) -> str:
    """What a command prints; raises ToolError with the command's words where it fails or takes too long."""
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            capture_output=True,
            text=True,
            stdin=subprocess.DEVNULL,
            timeout=TIME_LIMIT_S,
        )
    except subprocess.TimeoutExpired:
        raise ToolError(f"{command[0]} did not end within {TIME_LIMIT_S} s") from None
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["nothing said"]
        first = next((line for line in lines if "error" in line), lines[-1])
        raise ToolError(f"{command[0]} ended with {done.returncode}: {first}")
    return done.stdout


def _has_c_library(target: Target) -> bool:
    # Debian's compilers come without a C library, which is another package.
    headers = ["-xc", "-E", "-o", "/dev/null", "-"]
    code = "#include <unistd.h>\n"
    command = [f"{target.tools}gcc", *target.flags, *headers]
    return subprocess.run(command, input=code, capture_output=True, text=True).returncode == 0
