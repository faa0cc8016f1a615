"""How much memory an allocator and a process hold."""

import gc
import sys
from pathlib import Path
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

import numpy as np

from alloc import Vehicle

_CODE = (type, ModuleType, BuiltinFunctionType, Vehicle)


def reachable_bytes(thing: object) -> int:
    """Bytes of all Python objects and arrays reachable from ``thing``.

    Code, modules and the vehicle, which is the caller's, are left out. Python can't see what the C or C++
    side of a solver allocates for itself; the peak RSS of the worker includes it.
    """
    seen: set[int] = set()
    todo: list[Any] = [thing]
    total = 0
    while todo:
        held = todo.pop()
        if id(held) in seen or isinstance(held, _CODE):
            continue
        seen.add(id(held))
        if isinstance(held, FunctionType):
            # A cell of a name that nothing was ever given is empty, and has no contents to ask for.
            todo += gc.get_referents(*(held.__closure__ or ()))
            continue
        total += sys.getsizeof(held)
        if isinstance(held, np.ndarray):
            if held.base is not None:
                todo.append(held.base)
        else:
            todo += gc.get_referents(held)
    return total


def peak_rss_bytes() -> int | None:
    """High-water mark of this process's resident memory [bytes], None where the system does not tell.

    It is read from /proc: getrusage's ru_maxrss of a child starts at its parent's (Linux, exec(2) keeps it).
    """
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return None
    line = next((line for line in status.splitlines() if line.startswith("VmHWM:")), None)
    return None if line is None else int(line.split()[1]) * 1024
