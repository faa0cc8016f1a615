"""Compilers and emulators: which are missing, how to get those, and what they say."""

import atexit
import platform
import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from alloc import AllocError
from bench.chips.target import Target


class ToolError(AllocError):
    """A compiler or an emulator failed; the message names it and quotes its own."""


TIME_LIMIT_S = 900
"""The longest command takes about a minute: OSQP's C in double precision, where double is software."""


def missing(target: Target) -> str:
    """What a target lacks and how to get it, in one line; empty where it lacks nothing."""
    if target.callgrind and platform.machine() != "x86_64":
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


@cache
def scratch() -> Path:
    """A folder for what is compiled once for all kernels; it is removed as this process ends."""
    folder = tempfile.TemporaryDirectory(prefix="thrustbench-")
    atexit.register(folder.cleanup)
    return Path(folder.name)


def _has_c_library(target: Target) -> bool:
    # Debian's compilers come without a C library, which is another package.
    headers = ["-xc", "-E", "-o", "/dev/null", "-"]
    code = "#include <unistd.h>\n"
    command = [f"{target.tools}gcc", *target.flags, *headers]
    return subprocess.run(command, input=code, capture_output=True, text=True).returncode == 0
