"""Helpers for tests of runs: a run as a process of its own, and waiting for its progress."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from bench.demands import DemandSet
from bench.harness.inputs import doubt_contenders, doubt_demands, read_contenders, read_demands
from bench.harness.plan import Contender, RunSettings
from bench.record import FILE_NAME
from tests.places import ROOT


def started(*command: str) -> subprocess.Popen[bytes]:
    """Python with these arguments, as a process whose output can be read."""
    return subprocess.Popen(
        [sys.executable, *command], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )


def written(folder: Path) -> bytes:
    """The record in a folder so far, empty where there is none yet."""
    path = folder / FILE_NAME
    return path.read_bytes() if path.exists() else b""


def wait_for(condition: Callable[[], object], seconds: float = 100.0) -> None:
    """Return as soon as the condition holds; fails where it does not within so many seconds."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"not within {seconds:g} s"
        time.sleep(0.01)


def contenders(settings: RunSettings) -> list[Contender]:
    """The methods of a run, read and doubted."""
    chosen = read_contenders(settings)
    doubt_contenders(chosen, settings)
    return chosen


def demand_sets(settings: RunSettings) -> tuple[list[DemandSet], list[str]]:
    """The demand sets of a run, read and doubted, and the doubts."""
    demands = read_demands(settings)
    return demands.sets, doubt_demands(demands)
