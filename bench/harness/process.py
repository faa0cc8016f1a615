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
    assert process.stdout is not None
    printed = process.stdout.fileno()
    decode = msgspec.json.Decoder(Message).decode
    at: int | None = 0  # the task under way; a process that dies before its first task has lost that one
    pending, tail = b"", b""
    deadline = time.monotonic() + STARTUP_S
    with selectors.DefaultSelector() as selector:
        selector.register(reader, selectors.EVENT_READ)
        selector.register(printed, selectors.EVENT_READ)
        while selector.get_map():
            ready = selector.select(max(0.0, deadline - time.monotonic()))
            for key, _ in ready:
                data = os.read(key.fd, 1 << 16)
                if not data:
                    selector.unregister(key.fd)
                elif key.fd == printed:
                    tail = (tail + data)[-TAIL_BYTES:]
                else:
                    *lines, pending = (pending + data).split(b"\n")
                    for line in lines:
                        try:
                            message = decode(line)
                        except (msgspec.DecodeError, UnicodeDecodeError) as error:
                            if at is not None:
                                yield Failed(at, "failed", f"the result can't be recorded: {error}")
                            return
                        if not _expected(message, at, tasks):
                            if at is not None:
                                yield Failed(at, "failed", "the worker sent a message about another task")
                            return
                        at = message.task if isinstance(message, Begin) else None
                        yield message
                    deadline = time.monotonic() + time_limit_s
            if time.monotonic() >= deadline:
                if at is not None:
                    yield Failed(at, "timeout", f"no answer within {time_limit_s:g} s")
                return
    try:
        code = process.wait(timeout=time_limit_s)
    except subprocess.TimeoutExpired:  # a method may close every file of its process and go on
        how = Failed(at or 0, "timeout", f"no answer within {time_limit_s:g} s")
    else:
        how = Failed(at or 0, "crashed", cause(code, tail))
    if at is not None:
        yield how


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
