"""Compilers and emulators: which are missing, how to get those, and what they say."""

import atexit
import os
import platform
import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from alloc import AllocError
from bench.chips.processors import Processor


class ToolError(AllocError):
    """A compiler or an emulator failed; the message names it and quotes its own."""


TIME_LIMIT_S = 900
"""The longest command takes about a minute: OSQP's C in double precision, where double is software."""


def missing(processor: Processor) -> str:
    """Tools that a processor lacks and how to get them, in one line; empty where it lacks nothing."""
    if processor.callgrind and platform.machine() != "x86_64":
        return f"{processor.name} needs callgrind on an x86-64 machine: it emulates no other"
    commands = [f"{processor.tools}gcc", processor.emulator[0], "gcc"]
    absent = [command for command in dict.fromkeys(commands) if not shutil.which(command)]
    if not absent and not _has_c_library(processor):
        absent = ["a C library for it"]
    remedy = f"apt-get install {' '.join(processor.packages)} (or make emulate)"
    return f"{processor.name} needs {', '.join(absent)}: {remedy}" if absent else ""


def versions(processor: Processor) -> dict[str, str]:
    """Versions of a processor's compiler and emulator, by command."""
    printed = {name: run([name, "--version"]) for name in (f"{processor.tools}gcc", processor.emulator[0])}
    return {name: (re.search(r"\d+\.\d+(\.\d+)?", text) or [""])[0] for name, text in printed.items()}


def ended(
    command: list[str], folder: Path | None = None, limit_s: float = TIME_LIMIT_S, given: str = "", **env: str
) -> "subprocess.CompletedProcess[str]":
    """A command that was run to its end, ``given`` a text; raises ToolError where it takes too long.

    ``env`` are variables of its environment besides this process's.
    """
    try:
        return subprocess.run(
            command,
            cwd=folder,
            env={**os.environ, **env},
            input=given,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=limit_s,
        )
    except subprocess.TimeoutExpired:
        raise ToolError(f"{command[0]} did not end within {limit_s} s") from None


def run(command: list[str], folder: Path | None = None) -> str:
    """Output of a command; raises ToolError with the command's words where it fails or takes too long."""
    done = ended(command, folder)
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["nothing said"]
        first = next((line for line in lines if "error" in line), lines[-1])
        raise ToolError(f"{command[0]} ended with {done.returncode}: {first}")
    return done.stdout


@cache
def scratch() -> Path:
    """A folder for what is compiled once for all kernels; it is removed as this process ends."""
    folder = tempfile.mkdtemp(prefix="thrustbench-")
    # A TemporaryDirectory would be gone with the first forked child: since CPython 3.13 that lets go of it.
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def _has_c_library(processor: Processor) -> bool:
    # Debian's compilers come without a C library, which is another package.
    headers = ["-xc", "-E", "-o", "/dev/null", "-"]
    code = "#include <unistd.h>\n"
    return ended([f"{processor.tools}gcc", *processor.flags, *headers], given=code).returncode == 0
