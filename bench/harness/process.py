"""Worker processes, which may crash or hang: what they are asked, what they answer, how they ended."""

import os
import selectors
import signal
import subprocess
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, TypeVar

import msgspec

from alloc import AllocError
from bench.harness import environment
from bench.record import Cell, Key, Method, Worker

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

LONGEST = 200
"""Letters that are kept of the last line that a process printed."""
TAIL_BYTES = 2000
"""The last bytes that a worker printed are kept, to say why it died."""
STARTUP_S = 60.0
"""Time limit from the start of a process to its first task: Python, numpy and a cold disk."""


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
DECODE = msgspec.json.Decoder(Message).decode


def cause(code: int, printed: bytes) -> str:
    """Cause of a process's end: the signal or the exit code, and the last line that it printed."""
    how = _signal(-code) if code < 0 else f"exit code {code}"
    lines = printed.decode(errors="replace").strip().splitlines()
    return f"{how}: {lines[-1][:LONGEST]}" if lines else how


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # Python names only the first and the last of the real-time signals
        return f"signal {number}"


def work(job: Job, time_limit_s: float) -> Iterator[Message]:
    """Run a job in a fresh process; yield its messages as they come.

    A process that dies, reaches the time limit of a task, or sends what is no message, is ended; the task
    that it was at comes as Failed (crashed, timeout or failed), and the rest of the job is not done. The
    process is gone when the iteration ends, also when the caller stops early.
    """
    with ExitStack() as at_end:
        with delay_signals():
            command = [sys.executable, "-m", "bench.harness.worker"]
            process, reader = start(command, at_end, environment(PYTHONHASHSEED="0"))
        assert process.stdin is not None
        with suppress(BrokenPipeError):  # the process died at once; what it printed says why
            process.stdin.write(msgspec.json.encode(job))
            process.stdin.close()
        yield from _messages(process, reader, job.tasks, time_limit_s)


def start(
    command: Sequence[str], at_end: ExitStack, env: Mapping[str, str], cwd: Path | None = None
) -> tuple[subprocess.Popen[bytes], int]:
    """Start a process, whose last argument is the pipe for its messages; the other end of that pipe.

    ``at_end`` ends the process and closes the pipe.
    """
    reader, writer = os.pipe()
    at_end.callback(os.close, reader)
    try:
        process = subprocess.Popen(
            [*command, str(writer)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=[writer],
            env=env,
            cwd=cwd,
            start_new_session=True,  # a terminal's Ctrl-C reaches the parent only, which then stops in order
        )
    finally:
        os.close(writer)
    at_end.callback(_end, process)
    return process, reader


@contextmanager
def delay_signals() -> Iterator[None]:
    """Delay SIGINT and SIGTERM to the end of the block: a process must not start with nobody to end it."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals interrupt the main thread only
        return
    came: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: came.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    for late in came:
        signal.raise_signal(late)


def _messages(
    process: subprocess.Popen[bytes], reader: int, tasks: Sequence[Task], time_limit_s: float
) -> Iterator[Message]:
    at: int | None = 0  # the task under way; a process that dies before its first task has lost that one
    tail = bytearray()
    try:
        for line in lines(process, reader, tail, time_limit_s, STARTUP_S):
            message = _decoded(line, at, tasks)
            if isinstance(message, str):
                if at is not None:
                    yield Failed(at, "failed", message)
                return
            at = message.task if isinstance(message, Begin) else None
            yield message
        # A method may close every file of its process and go on.
        how, why = "crashed", cause(process.wait(timeout=time_limit_s), bytes(tail))
    except (TimeoutError, subprocess.TimeoutExpired):
        how, why = "timeout", f"no answer within {time_limit_s:g} s"
    if at is not None:
        yield Failed(at, how, why)


def lines(
    process: subprocess.Popen[bytes], reader: int, tail: bytearray, time_limit_s: float, first_s: float
) -> Iterator[bytes]:
    """Lines that a process sends until it ends; ``tail`` gets the last of what it prints.

    Raises TimeoutError where the first takes longer than ``first_s``, or another than ``time_limit_s``.
    """
    assert process.stdout is not None
    printed = process.stdout.fileno()
    pending = b""
    deadline = time.monotonic() + first_s
    with selectors.DefaultSelector() as selector:
        selector.register(reader, selectors.EVENT_READ)
        selector.register(printed, selectors.EVENT_READ)
        while selector.get_map():
            for key, _ in selector.select(max(0.0, deadline - time.monotonic())):
                data = os.read(key.fd, 1 << 16)
                if not data:
                    selector.unregister(key.fd)
                elif key.fd == printed:
                    tail[:] = (tail + data)[-TAIL_BYTES:]
                else:
                    *whole, pending = (pending + data).split(b"\n")
                    yield from whole
                    deadline = time.monotonic() + time_limit_s
            if time.monotonic() >= deadline:
                raise TimeoutError


def _decoded(line: bytes, at: int | None, tasks: Sequence[Task]) -> Message | str:
    """The message in a line, or why there is none that a worker at that task may send."""
    try:
        message = DECODE(line)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        return f"the result can't be recorded: {error}"
    return message if _expected(message, at, tasks) else "the worker sent a message about another task"


def _expected(message: Message, at: int | None, tasks: Sequence[Task]) -> bool:
    """True if a worker at that task may send this message; a method can write into the worker's pipe too."""
    task = None if at is None else tasks[at]
    match message:
        case Begin():
            return message.task in range(len(tasks))
        case Failed():
            return message.task == at
        case AnswersWritten():
            return message.task == at and isinstance(task, AnswerTask)
        case Cell():
            return isinstance(task, MeasureTask) and task.key == message.key
        case _:
            return True


def _end(process: subprocess.Popen[bytes]) -> None:
    # The worker leads a session of its own, so processes that it started are ended with it.
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for stream in (process.stdin, process.stdout):
        assert stream is not None
        with suppress(BrokenPipeError):  # the part of the job that the worker had not read
            stream.close()


Made = TypeVar("Made")


def run_in_copy(work: Callable[[], Made], who: str) -> Made:
    """Result of ``work``, from a copy of this process.

    What the work prints goes to standard error. What it changes in memory, and the folder that it goes to,
    are gone with the copy. Raises AllocError with the message of one that the work raises, and where the copy
    ended without an answer, by a signal or ``os._exit``: then the message begins with ``who`` did the work.
    """
    from multiprocessing import get_context  # no worker needs it

    context = get_context("fork")
    reader, writer = context.Pipe(duplex=False)
    copy = context.Process(target=_reply, args=(work, writer))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # numpy's threads, which are idle
        copy.start()
    writer.close()
    try:
        made, refusal = reader.recv()
    except Exception:  # a copy that ends in the middle of its reply leaves any bytes
        copy.join()
        how = cause(copy.exitcode or 0, b"")
        raise AllocError(f"{who}: ended its process ({how}) before it had answered; mend it") from None
    except BaseException:  # Ctrl-C: nobody waits for the reply any more
        copy.kill()
        raise
    finally:
        copy.join()
        reader.close()
    if refusal:
        raise AllocError(refusal)
    answered: Made = made
    return answered


def _reply(work: Callable[[], object], writer: "Connection") -> NoReturn:
    """Do the work, send what it made or why it did not, and end this copy."""
    try:
        os.dup2(2, 1)
        sys.stdout = sys.stderr
        try:
            writer.send((work(), ""))
        except AllocError as error:
            writer.send((None, str(error)))
        sys.stderr.flush()
        os._exit(0)
    except KeyboardInterrupt:
        os._exit(1)
    except BaseException:
        traceback.print_exc()
        os._exit(1)
