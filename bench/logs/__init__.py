"""Logs of demands, read by the kind of file they are in. One file one kind, found by itself.

A module has ``SUFFIXES`` and ``read(path, dof) -> (t, taus)``: t (N,) seconds, never decreasing, or
None; taus (N, k) [N, N m] with columns in the order of ``dof`` and in the vehicle's frame, z down.
"""

import pkgutil
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

from alloc import FileError
from alloc.allocation import FloatArray


def read_log(path: Path, dof: tuple[str, ...]) -> tuple[FloatArray | None, FloatArray]:
    """Times and demands in a log; raises FileError, DemandError, or NotInstalled with the remedy."""
    kinds: dict[str, ModuleType] = {}
    for found in pkgutil.iter_modules(__path__):
        module = import_module(f"bench.logs.{found.name}")
        kinds.update(dict.fromkeys(module.SUFFIXES, module))
    suffix = "/" if path.is_dir() else path.suffix.lower()
    if suffix not in kinds:
        known = ", ".join(sorted(set(kinds) - {"", "/"}))
        raise FileError(f"{path}: can't tell what kind of log this is; give {known} or a bag's folder")
    t, taus = kinds[suffix].read(path, dof)
    return t, taus


def rate_hz(t: FloatArray | None) -> float | None:
    """Sampling rate of a log: one over the median step [Hz]; None where there is no time or no step."""
    if t is None or len(t) < 2:
        return None
    step = float(np.median(np.diff(t)))
    return 1 / step if step > 0 else None
