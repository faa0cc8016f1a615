"""What the parent asks of a worker, and what a worker says."""

import msgspec

from bench.record import Cell, Key, Method, Worker


class MeasureTask(msgspec.Struct, tag="measure"):
    """One cell to measure.

    Attributes
    ----------
    key : what names it
    question : file of its ``bench.judging.question.Question``
    """

    key: Key
    question: str


class AnswerTask(msgspec.Struct, tag="answer"):
    """Demands to answer, untimed.

    Attributes
    ----------
    case : file of the vehicle and the demands on it (``bench.demands.store``)
    answers : file that the worker writes: thrusts ``F`` (N, n) and ``status`` (N,)
    """

    case: str
    answers: str


class DescribeTask(msgspec.Struct, tag="describe"):
    """A plug-in's catalogue entry."""


Task = MeasureTask | AnswerTask | DescribeTask


class Job(msgspec.Struct, kw_only=True):
    """All tasks of one worker process: one method with its start and level, one repeat.

    Attributes
    ----------
    method, start, level, repeat : what it runs
    tasks : in order
    plugin : file of the method, None where it is the catalogue's
    budget_ns : timed calls of a cell, roughly
    memory_bytes : what the process may allocate
    core : where it is pinned, None for anywhere
    spawned_ns : ``time.monotonic_ns()`` as the parent started it
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
    """The worker turns to the task of that number now; its time limit starts."""

    task: int


class AnswersWritten(msgspec.Struct, tag="answered"):
    """The answers to the task of that number are written."""

    task: int


class Described(msgspec.Struct, tag="described"):
    """A plug-in says of itself what an ``alloc.Entry`` holds.

    Attributes
    ----------
    method : as the record keeps it
    starts, levels : what it offers
    """

    method: Method
    starts: tuple[str, ...]
    levels: tuple[str, ...]


class Failed(msgspec.Struct, tag="failed"):
    """The task of that number came to nothing.

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
