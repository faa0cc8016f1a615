"""Environment that every measured process starts in, and words for how a process ended."""

import os
import signal
from pathlib import Path

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""Keeps the libraries under numpy to one thread; they read it once, as numpy is first imported."""
LONGEST = 200
"""Letters that are kept of the last line that a process printed."""
_ROOT = str(Path(__file__).parents[2])


def environment(*, isolated: bool = False, **more: str) -> dict[str, str]:
    """This process's environment with one thread a library, this project on Python's path, and ``more``.

    ``isolated`` leaves out every variable that is set for Python here, its path included, for a process
    that imports another tree.
    """
    if isolated:
        inherited = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    else:
        path = os.pathsep.join(filter(None, [_ROOT, os.environ.get("PYTHONPATH", "")]))
        inherited = {**os.environ, "PYTHONPATH": path}
    return {**inherited, **ONE_THREAD, **more}


def cause(code: int, printed: bytes) -> str:
    """Cause of a process's end: the signal or the exit code, and the last line that it printed."""
    how = _signal(-code) if code < 0 else f"exit code {code}"
    lines = printed.decode(errors="replace").strip().splitlines()
    return f"{how}: {lines[-1][:LONGEST]}" if lines else how


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # Python names only the first and the last of the real-time signals
        return f"signal {number}"
