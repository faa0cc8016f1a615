"""Projects of a board that tests build on this computer."""

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from alloc import load_vehicle
from alloc.program import Scalar
from bench.chips.board.log import Heard
from bench.chips.board.project import Project, plan, write

METHODS = ("nullspace@native", "pinv@native")
SETS = ("inactive", "active", "infeasible")


def project(scalar: Scalar = "double", n: int = 20) -> Project:
    return plan(load_vehicle("ukwial"), METHODS, SETS, scalar, "fixed", n, 3)


def make(folder: Path, *words: str) -> None:
    """Build with `make`; skips without a tool, and fails with the compiler's words."""
    compiler = next((word[3:] for word in words if word.startswith("CC=")), os.environ.get("CC", "cc"))
    for tool in ("make", compiler):
        if not shutil.which(tool):
            pytest.skip(f"needs {tool}")
    done = subprocess.run(["make", *words], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def printed(folder: Path, made: Project, passes: int) -> bytes:
    """The log of a project that runs on this computer, each demand timed ``passes`` times."""
    write(made, folder)
    make(folder, "log", f"CFLAGS=-O1 -DBOARD_PASSES={passes}")
    return (folder / "build/posix/LOG").read_bytes()


Hear = Callable[[bytes], list[Heard]]
