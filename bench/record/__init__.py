"""Record of a run: facts as they were measured, one line each, written and read here."""

from bench.record.capability import (
    SERVED_WITHIN,
    Authority,
    Capability,
    Curve,
    LastMetre,
    Plane,
    Served,
    Unserved,
)
from bench.record.cell import FARTHER, Batch, Cell, Judged, Key, Quiet
from bench.record.emulated import BoardFacts, Emulated, Processor
from bench.record.reader import FILE_NAME, PACKED, Record, RecordError, parse, read
from bench.record.schema import NO_VEHICLE, SCHEMA, Event, Header, Line, Method, Problem, Worker

__all__ = [
    "FARTHER",
    "FILE_NAME",
    "NO_VEHICLE",
    "PACKED",
    "SCHEMA",
    "SERVED_WITHIN",
    "Authority",
    "Batch",
    "BoardFacts",
    "Capability",
    "Cell",
    "Curve",
    "Emulated",
    "Event",
    "Header",
    "Judged",
    "Key",
    "LastMetre",
    "Line",
    "Method",
    "Plane",
    "Problem",
    "Processor",
    "Quiet",
    "Record",
    "RecordError",
    "Served",
    "Unserved",
    "Worker",
    "parse",
    "read",
]
