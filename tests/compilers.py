"""C that a test writes, compiles and runs; the test is skipped where a compiler is missing."""

import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from alloc.c import compiled

WARNINGS = [
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Wundef", "-Werror",
]  # fmt: skip


def needs(*commands: str) -> None:
    """Skip where a command is missing."""
    for command in commands:
        if shutil.which(command) is None:
            pytest.skip(f"needs {command}")


def write(folder: Path, files: Mapping[str, str]) -> list[str]:
    """Write files of generated C; returns what a compiler is given, all sources."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return [name for name in files if name.endswith(".c")]


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def build_program(folder: Path, files: Mapping[str, str], *options: str) -> Path:
    """The program made of these files, every warning an error; options may make it an object or a library."""
    command = [*compiled.compiler(), "-std=c99", *WARNINGS, "-I.", *options]
    done = run([*command, *write(folder, files), "-o", "made"], folder)
    assert done.returncode == 0, done.stderr[:2000]
    return folder / "made"
