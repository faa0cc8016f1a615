"""Plan a run, start workers, time calls of methods, and keep the results in a record."""

import os
from pathlib import Path

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""Keeps the libraries under numpy to one thread; they read it once, as numpy is first imported."""
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
