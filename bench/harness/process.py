"""One worker process from start to end: its messages as they come, its time limit, and how it ended."""

import os
import selectors
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress

import msgspec

from bench.harness.child import cause, environment
from bench.harness.job import AnswersWritten, AnswerTask, Begin, Failed, Job, MeasureTask, Message, Task
from bench.record import Cell

TAIL_BYTES = 2000
"""The last bytes that a worker printed are kept, to say why it died."""
STARTUP_S = 60.0
"""Time limit from the start of a process to its first task: Python, numpy and a cold disk."""

DECODE = msgspec.json.Decoder(Message).decode


def work(job: Job, time_limit_s: float) -> Iterator[Message]:
    """Run a job in a fresh process; yield its messages as they come.

    A process that dies, reaches the time limit of a task, or sends what is no message, is ended; the task
    that it was at comes as Failed (crashed, timeout or failed), and the rest of the job is not done. The
    process is gone when the iteration ends, also when the caller stops early.
    """
    job.spawned_ns = time.monotonic_ns()
    with ExitStack() as at_end:
        with signals_held_back():
            process, reader = _start(at_end)
        assert process.stdin is not None
        with suppress(BrokenPipeError):  # the process died at once; what it printed says why
            process.stdin.write(msgspec.json.encode(job))
            process.stdin.close()
        yield from _messages(process, reader, job.tasks, time_limit_s)


def _start(at_end: ExitStack) -> tuple[subprocess.Popen[bytes], int]:
    # A fresh worker, and the pipe that its messages come through; ``at_end`` removes both.
    reader, writer = os.pipe()
    at_end.callback(os.close, reader)
    try:
        process = subprocess.Popen(
            [sys.executable, "-m", "bench.harness.worker", str(writer)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            pass_fds=[writer],
            env=environment(PYTHONHASHSEED="0"),
            start_new_session=True,  # a terminal's Ctrl-C reaches the parent only, which then stops in order
        )
    finally:
        os.close(writer)
    at_end.callback(_end, process)
    return process, reader


@contextmanager
def signals_held_back() -> Iterator[None]:
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
        for line in _lines(process, reader, tail, time_limit_s):
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


def _lines(
    process: subprocess.Popen[bytes], reader: int, tail: bytearray, time_limit_s: float
) -> Iterator[bytes]:
    """The lines that a process sends; ``tail`` gets the last of what it prints. Raises TimeoutError."""
    assert process.stdout is not None
    printed = process.stdout.fileno()
    pending = b""
    deadline = time.monotonic() + STARTUP_S
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
                    *lines, pending = (pending + data).split(b"\n")
                    yield from lines
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
    """Whether a worker at that task may send this message; a method can write into the worker's pipe too."""
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
