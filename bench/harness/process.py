"""One worker process from start to end: its lines as they come, its time limit, how it died."""

import os
import selectors
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

import msgspec

from bench.harness.child import cause, environment
from bench.harness.job import Begin, Failed, Job, Message

TAIL_BYTES = 2000
"""How much of what a worker prints is kept, to say why it died."""
STARTUP_S = 60.0
"""Time limit from the start of a process to its first task: Python, numpy and a cold disk."""


def work(job: Job, time_limit_s: float) -> Iterator[Message]:
    """Run a job in a fresh process; yield its messages as they come.

    Where the process dies or outlives the time limit, the task it was at comes as Failed with status
    crashed or timeout, and the rest of the job is not done. The process is gone when this ends, also
    when the caller stops early.
    """
    job.spawned_ns = time.monotonic_ns()
    with ExitStack() as at_end:
        with signals_held_back():
            process, reader = _start(at_end)
        assert process.stdin is not None
        with suppress(BrokenPipeError):  # it died at once; what it printed says why
            process.stdin.write(msgspec.json.encode(job))
            process.stdin.close()
        yield from _messages(process, reader, time_limit_s)


def _start(at_end: ExitStack) -> tuple[subprocess.Popen[bytes], int]:
    # A fresh worker and the pipe its messages come through; both are gone at the end.
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
    """Let SIGINT and SIGTERM come at the end of the block: a process must not start with nobody to end it."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals interrupt the main thread alone
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


def _messages(process: subprocess.Popen[bytes], reader: int, time_limit_s: float) -> Iterator[Message]:
    assert process.stdout is not None
    printed = process.stdout.fileno()
    decode = msgspec.json.Decoder(Message).decode
    at: int | None = 0  # until it begins, what it was to begin with
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
                        message = decode(line)
                        at = message.task if isinstance(message, Begin) else None
                        yield message
                    deadline = time.monotonic() + time_limit_s
            if time.monotonic() >= deadline:
                if at is not None:
                    yield Failed(at, "timeout", f"no answer within {time_limit_s:g} s")
                return
    code = process.wait(timeout=STARTUP_S)
    if at is not None:
        yield Failed(at, "crashed", cause(code, tail))


def _end(process: subprocess.Popen[bytes]) -> None:
    # By its id and that of its session: whatever it started itself goes with it.
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for stream in (process.stdin, process.stdout):
        assert stream is not None
        with suppress(BrokenPipeError):  # what it had not read yet
            stream.close()
