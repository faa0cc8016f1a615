"""Facts about the machine, and the core that is kept for what is measured."""

import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import metadata
from pathlib import Path
from typing import Any

import psutil

from bench.record.schema import slug

_GOVERNOR = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
_BOARD = Path("/proc/device-tree/model")
_ROOT = Path(__file__).parents[2]
_SOURCE = ("alloc", "bench")


def describe() -> dict[str, Any]:
    """Name, CPU, cores, memory, governor, OS and kernel; nothing that names a person or a host."""
    return {
        "name": name(),
        "cpu": cpu(),
        "cores": psutil.cpu_count(logical=True),
        "memory_GiB": round(psutil.virtual_memory().total / 2**30, 1),
        "architecture": platform.machine(),
        "virtual": "hypervisor" in _cpuinfo("flags"),
        "governor": _read(_GOVERNOR),
        "os": _os(),
        "kernel": f"{platform.system()} {platform.release()}",
    }


def name() -> str:
    """A folder name for this machine, e.g. ``amd-epyc-2-cores`` or ``raspberry-pi-4-model-b-rev-1.4``."""
    board = _read(_BOARD)
    text = board or f"{cpu()} {psutil.cpu_count(logical=True)} cores"
    return slug(text)


def cpu() -> str:
    """The processor's name as the system gives it, or the board's, or the architecture."""
    return _cpuinfo("model name") or _read(_BOARD) or platform.processor() or platform.machine()


def versions() -> dict[str, str]:
    """Versions of Python and of every package that thrustbench asks for and that is installed."""
    installed = {"python": f"{platform.python_implementation()} {platform.python_version()}"}
    for requirement in sorted(_requirements(), key=str.lower):
        try:
            installed[requirement] = metadata.version(requirement)
        except metadata.PackageNotFoundError:
            continue
    return installed


def commit() -> str:
    """The git commit of this source, with ``+changes`` where a file differs; empty outside a repository.

    Only the source counts: results that a run has written must not keep it from being resumed.
    """
    try:
        # Fails where this source is installed inside somebody else's repository, whose commit is not ours.
        _git("ls-files", "--error-unmatch", *_SOURCE)
        return _git("rev-parse", "--short=12", "HEAD") + (
            "+changes" if _git("status", "--porcelain", "--", *_SOURCE) else ""
        )
    except (OSError, subprocess.SubprocessError):
        return ""


def core() -> int | None:
    """The core that measured processes are pinned to, None where this system pins nothing."""
    return max(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None


@contextmanager
def reserve_core() -> Iterator[None]:
    """Keep every thread of this process off ``core()`` inside the block, where there is another core."""
    taken = core()
    if taken is None:
        yield
        return
    allowed = os.sched_getaffinity(0)
    _move(allowed - {taken} or allowed)
    try:
        yield
    finally:
        _move(allowed)


def _move(cores: set[int]) -> None:
    for thread in psutil.Process().threads():
        with suppress(ProcessLookupError):  # the thread has ended since it was listed
            os.sched_setaffinity(thread.id, cores)


def _requirements() -> set[str]:
    try:
        listed = metadata.requires("thrustbench") or []
    except metadata.PackageNotFoundError:  # this source tree is not installed
        listed = ["numpy", "scipy", "osqp", "clarabel", "proxsuite", "piqp", "daqp", "qpsolvers"]
    names = (re.match(r"[A-Za-z0-9_.-]+", line) for line in listed)
    return {match.group() for match in names if match} - {"thrustbench"}


def _os() -> str:
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        return f"{platform.system()} {sys.platform}"


def _cpuinfo(key: str) -> str:
    lines = _read(Path("/proc/cpuinfo")).splitlines()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith(key)), "")


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").strip("\x00\n ")
    except (OSError, UnicodeDecodeError):
        return ""


def _git(*arguments: str) -> str:
    done = subprocess.run(
        ["git", *arguments], cwd=_ROOT, check=True, capture_output=True, text=True, timeout=10
    )
    return done.stdout.strip()
