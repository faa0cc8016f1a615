"""Append to a record: one process at a time, whole lines only, continued after an interruption."""

import errno
import os
import time
from collections.abc import Iterable
from itertools import count
from pathlib import Path
from typing import Self

import msgspec
from filelock import FileLock, Timeout

from bench.record import FILE_NAME, PACKED, Header, Line, Record, RecordError, parse

PREVIOUS = "record.previous.jsonl"
"""Name that an older record gets where a new one is written: an hour's run is not lost to a short one. Still
older ones are ``record.previous-2.jsonl`` and so on."""
SYNC_EVERY_S = 2.0
"""A power cut loses the lines of at most this time; syncing each line would disturb the measurement [s]."""


def set_aside(record: Path) -> None:
    """Give a folder's record the name that an older one has, see PREVIOUS; nothing that is there is lost."""
    last = record.with_name(PREVIOUS)
    if last.exists():
        older = (last.with_name(PREVIOUS.replace(".jsonl", f"-{i}.jsonl")) for i in count(2))
        last.replace(next(path for path in older if not path.exists()))
    record.replace(last)


class Writer:
    """The only writer of a folder's record; a context manager that holds the folder's lock."""

    def __init__(self, directory: Path) -> None:
        """Lock ``directory`` (made if need be); raises RecordError where another run holds it."""
        self.path = directory / FILE_NAME
        try:
            directory.mkdir(parents=True, exist_ok=True)
            self._lock = FileLock(directory / ".lock")
            self._lock.acquire(timeout=0)
        except Timeout:
            raise RecordError(f"{directory}: another run writes here; wait for it or give --out") from None
        except OSError as error:
            raise RecordError(f"{directory}: can't be written ({error.strerror}); give --out") from None
        self._descriptor: int | None = None
        self._synced = time.monotonic()

    def create(self, header: Header) -> None:
        """Start a new record; older ones are kept, see PREVIOUS."""
        if self._has_lines():
            set_aside(self.path)
        self._open(os.O_TRUNC)
        self.append(header)

    def resume(self) -> Record | None:
        """Read the record, cut an incomplete last line off, and append from now on.

        None where there is no line yet, as after a kill before the first one. Raises RecordError for a
        packed record, which a new record beside it would hide.
        """
        if not self._has_lines():
            if (packed := self.path.with_name(PACKED)).exists():
                raise RecordError(f"{packed}: is packed, so nothing can be added; gunzip it first")
            return None
        record, whole = parse(self.path)
        self._open(0)
        assert self._descriptor is not None
        os.ftruncate(self._descriptor, whole)
        return record

    def append(self, line: Line) -> None:
        """Append a line in one write; on a full disk, keep the earlier lines and raise RecordError."""
        assert self._descriptor is not None, "create or resume first"
        data = msgspec.json.encode(line) + b"\n"
        end = os.fstat(self._descriptor).st_size
        try:
            if os.write(self._descriptor, data) < len(data):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            if time.monotonic() - self._synced > SYNC_EVERY_S:
                os.fsync(self._descriptor)
                self._synced = time.monotonic()
        except OSError as error:
            os.ftruncate(self._descriptor, end)
            raise RecordError(
                f"{self.path}: {error.strerror}; what was measured is kept, make room and go on with --resume"
            ) from None

    def extend(self, lines: Iterable[Line]) -> None:
        """Append several lines."""
        for line in lines:
            self.append(line)

    def _has_lines(self) -> bool:
        return self.path.is_file() and b"\n" in self.path.read_bytes()

    def _open(self, flags: int) -> None:
        try:
            self._descriptor = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | flags, 0o644)
        except OSError as error:
            raise RecordError(f"{self.path}: can't be written ({error.strerror}); give --out") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._descriptor is not None:
            os.fsync(self._descriptor)
            os.close(self._descriptor)
        self._lock.release()
