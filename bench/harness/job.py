"""Messages between the parent of a run and its workers."""

import msgspec

from bench.record import Cell, Key, Method, Worker


class MeasureTask(msgspec.Struct, tag="measure"):
    """One cell to measure.

    Attributes
    ----------
    key : names the cell
    question : file of the cell's ``bench.judging.question.Question``
    """

    key: Key
    question: str


class AnswerTask(msgspec.Struct, tag="answer"):
    """Demands to answer, untimed.

    Attributes
    ----------
    case : file of the vehicle and the demands on it (``bench.demands.store``)
    answers : file that the worker writes: thrusts ``F`` (N, n) [N] and ``status`` (N,)
    """

    case: str
    answers: str


class DescribeTask(msgspec.Struct, tag="describe"):
    """A plug-in to import, whose catalogue entry is wanted."""


Task = MeasureTask | AnswerTask | DescribeTask


class Job(msgspec.Struct, kw_only=True):
    """All tasks of one worker process: one method with its start and level, one repeat.

    Attributes
    ----------
    method, start, level, repeat : what the worker runs
    tasks : in the order in which they are done
    plugin : file of the method, None where the method is the catalogue's
    budget_ns : timed calls of a cell, roughly [ns]
    memory_bytes : most memory that the process may allocate
    core : where the process is pinned, None for anywhere
    spawned_ns : ``time.monotonic_ns()`` as the parent started the process
    """

    method: str
    tasks: list[Task]
    start: str = "-"
    level: str = "-"
    repeat: int = 0
    plugin: str | None = None
    budget_ns: int = 80_000_000
    memory_bytes: int = 2 << 30
    core: int | None = None
    spawned_ns: int = 0


class Begin(msgspec.Struct, tag="begin"):
    """The worker begins a task, whose time limit starts now.

    Attributes
    ----------
    task : its number
    """

    task: int


class AnswersWritten(msgspec.Struct, tag="answered"):
    """The file of an ``AnswerTask`` is written.

    Attributes
    ----------
    task : its number
    """

    task: int


class Described(msgspec.Struct, tag="described"):
    """Fields of the ``alloc.discovery.Entry`` of a plug-in.

    Attributes
    ----------
    method : as the record keeps it
    starts, levels : what the plug-in offers
    """

    method: Method
    starts: tuple[str, ...]
    levels: tuple[str, ...]


class Failed(msgspec.Struct, tag="failed"):
    """A task ended without a result.

    Attributes
    ----------
    task : its number
    status : failed, crashed, timeout, missing or refused
    reason : in words
    """

    task: int
    status: str
    reason: str


Message = Begin | Cell | AnswersWritten | Described | Failed | Worker
