"""Read a record, plain or gzipped; write one, whole lines only, continued after an interruption."""

import errno
import gzip
import os
import time
import zlib
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any, Self

import msgspec

from alloc import AllocError
from bench.record.capability import Capability
from bench.record.measured import Cell, Key
from bench.record.schema import (
    NO_VEHICLE,
    SCHEMA,
    Emulated,
    Event,
    Header,
    Line,
    Method,
    Problem,
    ProcessorFacts,
    Worker,
    unusable,
)

FILE_NAME = "record.jsonl"
PACKED = FILE_NAME + ".gz"
"""Name of a finished record after `gzip record.jsonl`: a fifth of the size, to be kept or mailed."""


class RecordError(AllocError):
    """A record can't be read, written, locked or continued; the message says which file and why."""


@dataclass(kw_only=True)
class Record:
    """A record as read: its header and its lines by kind, in the order they were written.

    Attributes
    ----------
    header : what ran where, with what
    methods, problems, capabilities, cells, workers, processors, emulated, events : the lines of each kind
    """

    header: Header
    methods: list[Method] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    capabilities: list[Capability] = field(default_factory=list)
    cells: list[Cell] = field(default_factory=list)
    workers: list[Worker] = field(default_factory=list)
    processors: list[ProcessorFacts] = field(default_factory=list)
    emulated: list[Emulated] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)

    @property
    def notes(self) -> list[str]:
        """Notes on how the logs of demands were read, and what may be wrong with them, each line once."""
        return list(dict.fromkeys(line for problem in self.problems for line in problem.said))

    def keys(self) -> set[Key]:
        """Keys of the cells that the record holds, measured or failed."""
        return {cell.key for cell in self.cells}


def read(directory: Path) -> Record:
    """Read ``directory/record.jsonl``, or ``record.jsonl.gz`` where only that is there; raises RecordError.

    A last line that a kill or a full disk cut short is left out.
    """
    plain, packed = directory / FILE_NAME, directory / PACKED
    return parse(packed if packed.exists() and not plain.exists() else plain)[0]


def parse(path: Path) -> tuple[Record, int]:
    """The record in a file, and how many bytes of it are whole lines; raises RecordError."""
    try:
        data = path.read_bytes()
        data = gzip.decompress(data) if path.name == PACKED else data
    except (OSError, EOFError, zlib.error) as error:  # a damaged archive raises any of the three
        reason = getattr(error, "strerror", None) or "not a whole gzip file"
        raise RecordError(f"{path}: can't be read ({reason}); give a run's folder") from None
    whole = data.rfind(b"\n") + 1
    lines = data[:whole].splitlines()
    if not lines:
        raise RecordError(f"{path}: holds no complete line; remove it and run again")
    _check_schema(path, lines[0])
    decode = msgspec.json.Decoder(Line).decode
    by_kind: defaultdict[type, list[Any]] = defaultdict(list)
    for number, text in enumerate(lines, start=1):
        try:
            line = decode(text)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            what = str(error)[:300]  # it may quote all of a value
            raise RecordError(f"{path}, line {number}: {what}; remove that line or run again") from None
        vehicle = line.key.vehicle if isinstance(line, Cell) else getattr(line, "vehicle", NO_VEHICLE)
        if why := unusable(vehicle):
            raise RecordError(f"{path}, line {number}: {why}; remove that line or run again")
        if number == 1 and not isinstance(line, Header):
            raise RecordError(f"{path}: line 1 is no header; remove the file and run again")
        by_kind[type(line)].append(line)
    return (
        Record(
            header=by_kind[Header][0],
            methods=by_kind[Method],
            problems=by_kind[Problem],
            capabilities=by_kind[Capability],
            cells=by_kind[Cell],
            workers=by_kind[Worker],
            processors=by_kind[ProcessorFacts],
            emulated=by_kind[Emulated],
            events=by_kind[Event],
        ),
        whole,
    )


def _check_schema(path: Path, line: bytes) -> None:
    # Checked before any line is decoded, because the lines of another schema need not have these fields.
    try:
        schema = msgspec.json.decode(line)["schema"]
    except (msgspec.DecodeError, UnicodeDecodeError, KeyError, TypeError):
        raise RecordError(f"{path}: line 1 is no header; remove the file and run again") from None
    if schema != SCHEMA:
        raise RecordError(f"{path}: has schema {schema}, this version reads {SCHEMA}; run again")


PREVIOUS = "record.previous.jsonl"
"""Name that an older record gets where a new one is written: an hour's run is not lost to a short one. Still
older ones are ``record.previous-2.jsonl`` and so on."""
SYNC_EVERY_S = 2.0
"""A power cut loses the lines of at most this time; syncing each line would disturb the measurement [s]."""


def rename_older(record: Path) -> None:
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
        from filelock import FileLock, Timeout  # only a writer pays for this import

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
            rename_older(self.path)
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


class CanaryError(AllocError):
    """A canary file, or a record's canaries, can't be used."""


class CanaryFile(msgspec.Struct):
    """One machine and its canaries.

    Attributes
    ----------
    canary_schema : 1, the only schema there is
    machine : what ``bench.harness.machine`` says of it (CPU, cores, memory, governor, OS, kernel)
    median_us : median time of each canary [us]
    """

    canary_schema: int
    machine: dict[str, str | int | float | bool | None]
    median_us: dict[str, float]


def read_canary(path: Path) -> CanaryFile:
    """Read a canary file; raises CanaryError."""
    remedy = "give a file that `thrustbench canary` wrote on the target"
    try:
        canaries = msgspec.json.decode(path.read_bytes(), type=CanaryFile)
    except OSError as error:
        raise CanaryError(f"{path}: can't be read ({error.strerror}); {remedy}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise CanaryError(f"{path}: {error}; {remedy}") from None
    if canaries.canary_schema != 1 or not canaries.median_us or min(canaries.median_us.values()) <= 0:
        raise CanaryError(f"{path}: holds no canary times of schema 1; {remedy}")
    return canaries
