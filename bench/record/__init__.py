"""What a run leaves behind: facts as they were measured (``schema``, ``capability``), and that read back."""

from bench.record.capability import Authority, Curve, Plane, Served, Worth
from bench.record.reader import FILE_NAME, PACKED, Record, RecordError, parse, read
from bench.record.schema import (
    SCHEMA,
    Batch,
    Cell,
    Emulated,
    Event,
    Header,
    Judged,
    Key,
    Line,
    Problem,
    Quiet,
    Worker,
)

__all__ = [
    "FILE_NAME",
    "PACKED",
    "SCHEMA",
    "Authority",
    "Batch",
    "Cell",
    "Curve",
    "Emulated",
    "Event",
    "Header",
    "Judged",
    "Key",
    "Line",
    "Plane",
    "Problem",
    "Quiet",
    "Record",
    "RecordError",
    "Served",
    "Worker",
    "Worth",
    "parse",
    "read",
]
