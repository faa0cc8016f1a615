"""A Dask scheduler and workers on loopback, each a process of its own."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.places import ROOT
from tests.runs import wait_for

DASK = (sys.executable, "-m", "dask")


class LoopbackCluster:
    """A scheduler that runs, and a way to start workers for it.

    Attributes
    ----------
    address : of the scheduler
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._processes: list[subprocess.Popen[bytes]] = []
        file = folder / "scheduler.json"
        self._start(
            "scheduler", "--port", "0", "--scheduler-file", str(file), "--no-dashboard", host="127.0.0.1"
        )
        wait_for(lambda: file.exists() and file.read_text().endswith("}"), 60)
        self.address: str = json.loads(file.read_text())["address"]

    def worker(self, host: str = "127.0.0.1", name: str = "worker") -> "subprocess.Popen[bytes]":
        """Start a worker at a loopback address; no nanny starts it again when it is killed."""
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--name", name)
        return self._start(
            "worker", self.address, *options, "--local-directory", str(self._folder), host=host
        )

    def end(self) -> None:
        """End all that was started."""
        for process in reversed(self._processes):
            process.kill()
            process.wait()

    def _start(self, kind: str, *options: str, host: str) -> "subprocess.Popen[bytes]":
        with (self._folder / f"{kind}-{len(self._processes)}.log").open("wb") as log:
            process = subprocess.Popen(
                [*DASK, kind, *options, "--host", host],
                cwd=ROOT,
                env={**os.environ, "TMPDIR": str(self._folder)},  # for Dask's folder and the host's lock
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        self._processes.append(process)
        return process


@contextmanager
def loopback_cluster(folder: Path) -> Iterator[LoopbackCluster]:
    """A scheduler without workers, ended afterwards with all workers that were started."""
    pytest.importorskip("distributed", reason="needs the extra fleet")
    cluster = LoopbackCluster(folder)
    try:
        yield cluster
    finally:
        cluster.end()
