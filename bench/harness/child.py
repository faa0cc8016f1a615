"""What every measured process has in common: the environment it starts in, and how its end is told."""

import os
import signal
from pathlib import Path

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""Keeps the libraries under numpy to one thread; they read it once, as numpy is first imported."""
LONGEST = 200
"""Letters of a process's last words that are told."""
_ROOT = str(Path(__file__).parents[2])


def environment(*, isolated: bool = False, **more: str) -> dict[str, str]:
    """This process's environment with one thread a library, this project to be found, and ``more``.

    ``isolated`` leaves out what is set for Python here, paths included: the process is to import a
    tree of its own.
    """
    if isolated:
        inherited = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    else:
        path = os.pathsep.join(filter(None, [_ROOT, os.environ.get("PYTHONPATH", "")]))
        inherited = {**os.environ, "PYTHONPATH": path}
    return {**inherited, **ONE_THREAD, **more}


def cause(code: int, printed: bytes) -> str:
    """What ended a process, in words: the signal or the exit code, and the last line that it printed."""
    how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    said = printed.decode(errors="replace").strip().splitlines()
    return f"{how}: {said[-1][:LONGEST]}" if said else how
