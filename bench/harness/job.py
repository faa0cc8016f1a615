"""What the parent asks of a worker, and what a worker says besides the lines of the record."""

import msgspec

from bench.record import Cell, Key, Worker


class Task(msgspec.Struct):
    """One cell to measure: its key and the file its question is stored in (see bench.judging.reference)."""

    key: Key
    question: str


class Job(msgspec.Struct):
    """All tasks of one worker process: one method with its start and level, one repeat.

    plugin: file of the method, where it is not the catalogue's. budget_ns: timed calls of a cell,
    roughly. memory_bytes: what the process may allocate. core: where it is pinned, None for
    anywhere. spawned_ns: ``time.monotonic_ns()`` as the parent started it.
    """

    method: str
    start: str
    level: str
    repeat: int
    tasks: list[Task]
    plugin: str | None = None
    budget_ns: int = 80_000_000
    memory_bytes: int = 2 << 30
    core: int | None = None
    spawned_ns: int = 0


class Begin(msgspec.Struct, tag="begin"):
    """The worker turns to this cell now; its time limit starts."""

    key: Key


Message = Begin | Cell | Worker
