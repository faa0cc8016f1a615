"""Plug-in files of methods that answer T* tau and misbehave, most of them on large demands only."""

import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import psutil

STUCK = "import os; open(os.path.join(os.path.dirname(__file__), f'stuck-{os.getpid()}'), 'w').close()"
"""Line of a plug-in that says that its process hangs from here on: ``limited_when_stuck`` waits for it."""
TEMPLATE = '''"""Goes wrong on purpose."""
import ctypes, os, sys, time
import numpy as np
from alloc import Allocation, Status
from alloc.closed_forms.inverse import generalized_inverse

FORMULATION = "unlimited"
FORGED = b'{{"type":"failed","task":99,"status":"ok","reason":""}}\\n'

class Allocator:
    formulation, limited, tolerance = FORMULATION, False, 1e-9

    def __init__(self, vehicle):
        self.G, self.kept, self.f = generalized_inverse(vehicle), [], np.empty(vehicle.n)
        self.limit, self.failed = vehicle.f_scale, bool(vehicle.faults)
        self.vehicle = vehicle

    def __call__(self, tau):
        f = self.G @ tau
        large = np.abs(f).max() > self.limit
        {body}
        return Allocation(f, Status.SOLVED)

def build(vehicle):
    return Allocator(vehicle)
'''

BODIES = {
    "segfaults": "if large: ctypes.string_at(0)",
    "loops": f"if large: {STUCK}\n        while large: time.sleep(0.01)",
    "raises": "if large: raise ValueError('no such demand')",
    "leaks": "if large: self.kept.append(np.empty(4_000_000))",
    "exits": "if large: os._exit(0)",
    "calls-exit": "if large: sys.exit(3)",
    "yesterday": "self.f[:] = f; f = self.f",
    "sleeps": "time.sleep(0.001)",
    "floods": "print('x' * 10_000); sys.stdout.flush()",
    "off": "f *= 1.001",
    "off-after-a-failure": "f *= 1.001 if self.failed else 1.0",
    "scribbles": "tau *= 0; f = f * 0; self.formulation = 'mine'",  # 'mine' has no reference
    "changes-its-vehicle": "self.vehicle.__dict__['TP'] = 2 * self.vehicle.T; f /= 2",
    "wrong-along-an-axis": "f = f if np.count_nonzero(tau) > 1 else -f",
    "nan": "f = f * np.nan if large else f",
}
TAMPERING = {
    "closes-files": "if large: os.closerange(3, 256)",
    "closes-files-and-hangs": f"if large: {STUCK}; os.closerange(0, 256); time.sleep(60)",
    "miscounts": "if large: return Allocation(f, Status.SOLVED, 2.5)",
    "promises-nan": "self.tolerance = np.nan",
    "promises-text": "self.limited = 'no'",
    "promises-a-misspelling": "self.formulation = 'unlimted'",
    "forges": "if large: os.write(int(sys.argv[1]), FORGED)",
    "forks": "if large and not self.kept: self.kept.append(f); os.fork() or sys.exit(0)",
}
"""These hurt the worker itself: its files, its process, or the types of its results."""


def write_plugin(folder: Path, name: str) -> str:
    """Write the plug-in file of that name; returns its path."""
    path = folder / f"{name.replace('-', '_')}.py"
    path.write_text(TEMPLATE.format(body=(BODIES | TAMPERING)[name]))
    return str(path)


@contextmanager
def limited_when_stuck(folder: Path) -> Iterator[None]:
    """Let a worker's time limit begin where its plug-in in this folder says that it hangs, and end at once.

    A busy machine takes any time for the calls of methods that answer.
    """

    def is_stuck() -> bool:
        return any(psutil.pid_exists(int(mark.name[6:])) for mark in folder.glob("stuck-*"))

    def wait(process: "subprocess.Popen[bytes]", timeout: float | None = None) -> int:
        while timeout is not None:
            try:
                return ends(process, 0.05)
            except subprocess.TimeoutExpired:
                if is_stuck():
                    raise
        return ends(process)

    ends: Callable[..., int] = subprocess.Popen.wait
    clock = SimpleNamespace(monotonic=lambda: 1e9 * is_stuck(), monotonic_ns=time.monotonic_ns)
    with patch("bench.harness.process.time", clock), patch.object(subprocess.Popen, "wait", wait):
        yield
