"""The analysers that proofs come from: which are there, how to get the others, and what they say."""

import os
import re
import shutil
import subprocess
from pathlib import Path

from alloc.c.compiled import compiler
from alloc.errors import NotInstalled
from bench.chips.toolchain import ToolError

PACKAGES = {"frama-c": "frama-c-base", "gappa": "gappa", "cppcheck": "cppcheck"}
"""Debian's package of each tool."""
TIME_LIMIT_S = 240
"""Of one question to one tool; nothing that is answered at all took a quarter of it."""


def absent() -> list[str]:
    """The tools that are not there, a C compiler among them."""
    return [tool for tool in PACKAGES if not shutil.which(tool)] + ["cc"] * (not compiler())


def remedy(tools: list[str]) -> str:
    """How to get these tools, in a few words."""
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
    done = subprocess.run([tool, option], capture_output=True, text=True, check=False)
    return (re.search(r"\d[^\s]*", done.stdout + done.stderr) or [""])[0]


def run(command: list[str], folder: Path, given: str = "") -> str:
    """What a tool prints, whatever its exit code; raises ToolError where it takes too long."""
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env={**os.environ, "PWD": str(folder), "LC_ALL": "C.UTF-8"},  # Frama-C goes by PWD
            input=given,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=TIME_LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise ToolError(f"{command[0]} did not end within {TIME_LIMIT_S} s") from None
    return done.stdout + done.stderr
