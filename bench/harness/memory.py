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

    Left out: code, modules, the vehicle (its caller's), and what a solver's C or C++ side allocates
    for itself, which Python can't see; the peak RSS of the worker includes that.
    """
    seen: set[int] = set()
    todo: list[Any] = [thing]
    total = 0
    while todo:
        found = todo.pop()
        if id(found) in seen or isinstance(found, _CODE):
            continue
        seen.add(id(found))
        if isinstance(found, FunctionType):
            todo += [cell.cell_contents for cell in found.__closure__ or ()]
            continue
        total += sys.getsizeof(found)
        if isinstance(found, np.ndarray):
            if found.base is not None:
                todo.append(found.base)
        else:
            todo += gc.get_referents(found)
    return total


def peak_rss_bytes() -> int | None:
    """High-water mark of this process's resident memory, None where the system does not tell.

    From /proc, not getrusage: ru_maxrss of a child starts at its parent's (Linux, exec(2) keeps it).
    """
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return None
    line = next((line for line in status.splitlines() if line.startswith("VmHWM:")), None)
    return None if line is None else int(line.split()[1]) * 1024
