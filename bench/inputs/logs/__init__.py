"""Logs of demands, read by the kind of file they are in. One file one kind, found by itself.

A module has ``SUFFIXES`` ("/" for a folder) and ``read(path, topic) -> Log``.
"""

import pkgutil
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np

from alloc import DOF, DemandError, FileError, FloatArray
from alloc.vehicle import LARGEST
from alloc.vehicle.geometry import from_flu
from bench.inputs.demand_csv import read_demands


class Log(NamedTuple):
    """What a bag or the like holds: times (N,) [s], wrenches (N, 6) surge to yaw, their frame."""

    t: FloatArray
    taus: FloatArray
    frame: str


def read_log(
    path: Path, dof: tuple[str, ...], topic: str = "", frame: str = ""
) -> tuple[FloatArray | None, FloatArray]:
    """Times and demands in a log.

    Parameters
    ----------
    path : the log; ``FILE#TOPIC`` names the topic as well, where no file is called so
    dof : the vehicle's DOF, which become the columns; the others are left out
    topic : which wrenches, where a bag has several
    frame : frd or flu, where the log's own idea of its frame is wrong

    Returns
    -------
    t : (N,) [s], never decreasing; None where a CSV has no column ``t``
    taus : (N, k) [N, N m] in the vehicle's frame, z down

    Raises
    ------
    FileError for what can't be read, DemandError for what holds no demands, NotInstalled with the remedy.
    """
    name, mark, fragment = str(path).rpartition("#")
    if mark and not path.exists():
        path, topic = Path(name), topic or fragment
    kinds: dict[str, ModuleType] = {}
    for found in pkgutil.iter_modules(__path__):
        module = import_module(f"bench.inputs.logs.{found.name}")
        kinds.update(dict.fromkeys(module.SUFFIXES, module))
    suffix = "/" if path.is_dir() else path.suffix.lower()
    if suffix in (".csv", ""):  # "": a pipe, as in <(zcat demands.csv.gz)
        return read_demands(path, dof)
    if suffix not in kinds:
        known = ", ".join(sorted(set(kinds) - {"/"}))
        raise FileError(f"{path}: can't tell what kind of log this is; give .csv, {known} or a bag's folder")
    if not path.exists():
        raise FileError(f"{path}: can't be read (no such file or directory); give a readable file")
    return _checked(path, kinds[suffix].read(path, topic), dof, frame)


def rate_hz(t: FloatArray | None) -> float | None:
    """Sampling rate of a log: one over the median step [Hz]; None where there is no time or no step."""
    if t is None or len(t) < 2:
        return None
    step = float(np.median(np.diff(t)))
    return 1 / step if step > 0 else None


def brief(error: Exception) -> str:
    """What a parser raised, in one short line."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:80]


def _checked(path: Path, log: Log, dof: tuple[str, ...], frame: str) -> tuple[FloatArray, FloatArray]:
    if not len(log.t):
        raise DemandError(f"{path}: holds no demands; record the demanded wrench")
    order = np.argsort(log.t, kind="stable")  # headers may arrive out of order
    t, taus = log.t[order], log.taus[order]
    taus = taus[:, [DOF.index(axis) for axis in dof]]
    bad = np.flatnonzero(~(np.abs(taus) <= LARGEST).all(axis=1))
    if bad.size:
        raise DemandError(
            f"{path}: the wrench at t = {t[bad[0]]:.3f} s is not finite, or above {LARGEST:g}; cut it out"
        )
    return t, from_flu(taus.T, dof).T if (frame or log.frame) == "flu" else taus
