"""Common parts of all kinds of logs: modules by suffix, errors of parsers, and the order of messages."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from textwrap import shorten
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike

from alloc import AllocError
from alloc.allocation import FloatArray, IndexArray
from alloc.errors import DemandError, FileError
from alloc.files.modules import modules
from bench.inputs.table import TABLES

LOGS = "bench.inputs.logs"
LATE = 1.0
"""Messages that are late by up to this are put in order; a time further back is another recording's [s]."""
DAMAGED = "it is damaged in places, so rows may be missing"
"""The remark on a log of which its parser had to leave something out."""


def reader(path: Path, function: str, what: str) -> ModuleType:
    """The module of logs that has a function for files with this suffix; raises FileError without one.

    The error says ``what`` kind of file is meant, and names the suffixes; or that there is no such file.
    """
    kinds: dict[str, ModuleType] = {
        suffix: module
        for module in modules(LOGS).values()
        for suffix in module.SUFFIXES
        if hasattr(module, function)
    }
    suffix = "/" if path.is_dir() else path.suffix.lower()
    if suffix not in kinds:
        known = ", ".join([*TABLES[:-1], *sorted(set(kinds) - {"/"})])
        folder = " or a bag's folder" if "/" in kinds else ""
        raise FileError(f"{path}: can't tell what kind of {what} this is; give {known}{folder}")
    if not path.exists():
        raise FileError(f"{path}: can't be read (no such file or directory); give a readable file")
    return kinds[suffix]


@contextmanager
def parsing(path: Path, what: str, library: str) -> Iterator[None]:
    """Raise FileError for whatever a parser raises: at damaged bytes that may be anything."""
    try:
        yield
    except AllocError:
        raise
    except Exception as error:
        said = shorten(f"{type(error).__name__}: {error}", 120, placeholder=" …")
        raise FileError(
            f"{path}: not a {what} that {library} can read ({said}); is it whole? copy it anew"
        ) from None


def in_order(path: Path, t: FloatArray) -> IndexArray:
    """The order (N,) of messages with times t [s]; raises DemandError where time goes back beyond LATE."""
    back = np.flatnonzero(np.diff(t) < -LATE)
    if back.size:
        before, behind = t[back[0] : back[0] + 2]
        raise DemandError(
            f"{path}: time goes back from {before:.6g} to {behind:.6g} s, as where a simulation was started"
            " again, or a clock was set; record each by itself, or cut it"
        )
    return np.argsort(t, kind="stable")


def timed(path: Path, stamps: ArrayLike, columns: Sequence[ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """Times (N,) [s] of stamps (N,) [us], and columns (N, m) of messages, in order; raises DemandError."""
    times = np.asarray(stamps, dtype=np.float64) / 1e6
    order = in_order(path, times)
    return times[order], np.column_stack(columns).astype(np.float64)[order]
