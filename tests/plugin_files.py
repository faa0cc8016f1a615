"""Plug-in files of methods that answer T* tau and misbehave, most of them on large demands only."""

from pathlib import Path

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
    "loops": "while large: time.sleep(0.01)",  # a loop that keeps a core busy is in test_signals.py
    "raises": "if large: raise ValueError('no such demand')",
    "leaks": "if large: self.kept.append(np.empty(4_000_000))",
    "exits": "if large: os._exit(0)",
    "calls-exit": "if large: sys.exit(3)",
    "yesterday": "self.f[:] = f; f = self.f",
    "sleeps": "time.sleep(0.003)",
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
    "closes-files-and-hangs": "if large: os.closerange(0, 256); time.sleep(60)",
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
