"""The analysers that proofs come from: which are there, how to get the others, and what they say."""

import re
import shutil
from collections.abc import Mapping
from pathlib import Path

from alloc.c.compiled import STANDARD, compiler
from alloc.errors import NotInstalled
from alloc.files.textfile import write_folder
from bench.chips.toolchain import ended

PACKAGES = {"frama-c": "frama-c-base", "cppcheck": "cppcheck"}
"""Debian's package of each tool."""
TIME_LIMIT_S = 600
"""Longest time of one question to one tool; answers took less than a quarter of it on a quiet machine."""


def absent() -> list[str]:
    """The tools that are not there, a C compiler among them."""
    return [tool for tool in PACKAGES if not shutil.which(tool)] + ["cc"] * (not compiler())


def remedy(tools: list[str]) -> str:
    """Remedy where these tools are missing, in a few words."""
    return f"apt-get install {' '.join(PACKAGES.get(tool, 'gcc') for tool in tools)} (or make prove)"


def need(tool: str) -> None:
    """Raise NotInstalled, with the remedy, where that tool is not there."""
    if tool in absent():
        raise NotInstalled(f"needs {tool}: {remedy([tool])}")


def version(tool: str) -> str:
    """The version a tool prints, empty where it is not there."""
    if not shutil.which(tool):
        return ""
    option = "-version" if tool == "frama-c" else "--version"
    done = ended([tool, option])
    return (re.search(r"\d[^\s]*", done.stdout + done.stderr) or [""])[0]


def run(command: list[str], folder: Path) -> str:
    """Output of a tool, whatever its exit code; raises ToolError where it takes too long."""
    # Frama-C takes its folder from PWD.
    done = ended(command, folder, TIME_LIMIT_S, PWD=str(folder), LC_ALL="C.UTF-8")
    return done.stdout + done.stderr


def tried(files: Mapping[str, str], folder: Path) -> tuple[bool, list[str]]:
    """True if ``tried``, made of these C files in a folder, ends with 0, and the lines that it prints."""
    write_folder(folder, files)
    sources = [name for name in files if name.endswith(".c")]
    built = run([*compiler(), *STANDARD, "-O1", "-g", "-I.", *sources, "-o", "tried"], folder)
    *said, last = run(["sh", "-c", "./tried && echo passed"], folder).strip().split("\n")
    return (True, said) if last == "passed" else (False, [*built.splitlines(), *said, last])
