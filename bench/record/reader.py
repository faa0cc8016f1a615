"""Read a record, plain or gzipped."""

import gzip
import zlib
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from alloc import AllocError
from bench.record.capability import Capability
from bench.record.cell import Cell, Key
from bench.record.emulated import Emulated, Processor
from bench.record.schema import NO_VEHICLE, SCHEMA, Event, Header, Line, Method, Problem, Worker, unusable

FILE_NAME = "record.jsonl"
PACKED = FILE_NAME + ".gz"
"""What `gzip record.jsonl` makes of a finished record: a fifth of the size, to be kept or mailed."""


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
    processors: list[Processor] = field(default_factory=list)
    emulated: list[Emulated] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)

    @property
    def said(self) -> list[str]:
        """How the logs of demands were understood, and what may be wrong with them, each line once."""
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
            raise RecordError(f"{path}: line {number}: {what}; remove that line or run again") from None
        vehicle = line.key.vehicle if isinstance(line, Cell) else getattr(line, "vehicle", NO_VEHICLE)
        if why := unusable(vehicle):
            raise RecordError(f"{path}: line {number}: {why}; remove that line or run again")
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
            processors=by_kind[Processor],
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
