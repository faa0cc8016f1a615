"""What runs where: a compiler and an emulator for each processor, and how to get what is missing."""

import platform
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from alloc import AllocError, UnknownName


class ToolError(AllocError):
    """A compiler or an emulator failed; the message says which and what it said."""


@dataclass(frozen=True)
class Target:
    """A processor, as a compiler and an emulator know it.

    Attributes
    ----------
    name : label in tables and on the command line
    tools : prefix of the compiler and its companions, e.g. ``arm-none-eabi-``
    flags : what the compiler must know about the processor
    emulator : command that runs an image, up to the image's path; empty runs it as it is
    packages : Debian's names of what all this needs
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
    quiet = ("-display", "none", "-monitor", "none", "-serial", "none")
    files = ("-semihosting-config", "enable=on,target=native")
    return ("qemu-system-arm", "-machine", machine, *quiet, *files, "-kernel")


_HOST = ("gcc", "libc6-dev")  # compiles the plugin that QEMU loads
_CORTEX_M = ("qemu-system-arm", "gcc-arm-none-eabi", "libnewlib-arm-none-eabi", *_HOST)
_HARD_FLOAT = ("-mthumb", "-mfloat-abi=hard")
TARGETS = (
    Target(
        "cortex-m7",
        "arm-none-eabi-",
        ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", *_HARD_FLOAT),
        _board("mps2-an500"),
        _CORTEX_M,
    ),
    Target(
        "cortex-m4f",
        "arm-none-eabi-",
        ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", *_HARD_FLOAT),
        _board("mps2-an386"),
        _CORTEX_M,
    ),
    Target(
        "aarch64",
        "aarch64-linux-gnu-",
        ("-static", "-mno-fix-cortex-a53-843419"),  # whose stubs fill a page, once there is one
        ("qemu-aarch64",),
        ("qemu-user", "gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross", *_HOST),
    ),
)
X86 = Target("x86-64", "x86_64-linux-gnu-", ("-static",), ("valgrind",), ("valgrind", *_HOST))
"""Where callgrind counts: the ratio to it says how far a count on a workstation carries."""

TIME_LIMIT_S = 900
"""The longest of these takes about a minute: OSQP's C in double precision where that is software."""


def target(name: str) -> Target:
    """The target of that name; raises UnknownName."""
    for found in (*TARGETS, X86):
        if found.name == name:
            return found
    raise UnknownName(f"no target '{name}'; there are {', '.join(t.name for t in TARGETS)}")


def missing(found: Target) -> str:
    """What is not there for a target and how to get it, in one line; empty where all is there."""
    if found == X86 and platform.machine() != "x86_64":
        return f"{found.name} needs callgrind on an x86-64 machine: it emulates no other"
    commands = [f"{found.tools}gcc", found.emulator[0], "gcc"]
    absent = [command for command in dict.fromkeys(commands) if not shutil.which(command)]
    if not absent and not _links(found):
        absent = ["a C library for it"]
    remedy = f"apt-get install {' '.join(found.packages)} (or make emulate)"
    return f"{found.name} needs {', '.join(absent)}: {remedy}" if absent else ""


def versions(found: Target) -> dict[str, str]:
    """Versions of what takes part: compiler and emulator."""
    said = {name: run([name, "--version"]) for name in (f"{found.tools}gcc", found.emulator[0])}
    return {name: (re.search(r"\d+\.\d+(\.\d+)?", text) or [""])[0] for name, text in said.items()}


def run(command: list[str], folder: Path | None = None) -> str:
    """What a command prints; raises ToolError with its own words where it fails, or takes too long."""
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
        said = (done.stderr or done.stdout).strip().splitlines() or ["nothing said"]
        first = next((line for line in said if "error" in line), said[-1])
        raise ToolError(f"{command[0]} ended with {done.returncode}: {first}")
    return done.stdout


def _links(found: Target) -> bool:
    # A compiler without its C library is the usual half of an installation.
    headers = ["-xc", "-E", "-o", "/dev/null", "-"]
    code = "#include <unistd.h>\n"
    command = [f"{found.tools}gcc", *found.flags, *headers]
    return subprocess.run(command, input=code, capture_output=True, text=True).returncode == 0
