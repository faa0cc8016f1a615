"""What a host of a fleet does: one run, by itself, and its record back."""

import gzip
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

import msgspec
from filelock import FileLock, Timeout

from bench.fleet.parcel import Parcel, unpack
from bench.harness import machine
from bench.harness.child import cause, environment
from bench.record import FILE_NAME

GOOD = (0, 1)
"""Exit codes of a run with a record: all answers right, or some wrong."""


class HostRun(msgspec.Struct, frozen=True, kw_only=True):
    """What a host sent back.

    Attributes
    ----------
    machine : the host's name for itself, from its processor or board
    code : exit code of its run
    reason : why there is no record, empty where there is one
    record : the packed record, empty without one
    """

    machine: str
    code: int = 0
    reason: str = ""
    record: bytes = b""


def run_here(parcel: Parcel, limit_s: float) -> HostRun:
    """Run `thrustbench run` with a parcel's arguments on this host, alone.

    A lock keeps two runs apart that came here over two workers, or from two callers. What takes longer than
    ``limit_s`` is ended, with all its processes.
    """
    name = machine.name()
    lock = FileLock(Path(tempfile.gettempdir()) / f"thrustbench-fleet-{os.getuid()}.lock")
    try:
        with lock.acquire(timeout=limit_s), tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
            return _run(name, parcel, Path(folder), limit_s)
    except Timeout:
        return HostRun(machine=name, reason=f"another run held this host for {limit_s:g} s")


def _run(name: str, parcel: Parcel, folder: Path, limit_s: float) -> HostRun:
    unpack(parcel, folder)
    out = folder / "out"
    with subprocess.Popen(
        [sys.executable, "-m", "bench", "run", *parcel.arguments, "--out", str(out)],
        cwd=folder,
        env=environment(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,  # its workers end with it
    ) as process:
        try:
            _, said = process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            return HostRun(machine=name, reason=f"its run took longer than {limit_s:g} s, and was ended")
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    record = out / FILE_NAME
    if process.returncode not in GOOD or not record.is_file():
        return HostRun(machine=name, code=process.returncode, reason=cause(process.returncode, said))
    return HostRun(machine=name, code=process.returncode, record=gzip.compress(record.read_bytes()))
