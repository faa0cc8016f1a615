"""A plugin of pytest, ``-p tests.in_process``: tests that start a process or serve on a socket are skipped.

What remains computes, renders and reads in this process. .ci/elsewhere runs it again under other kernels of
the linear algebra: processes of the others would inherit those, but start and wait for most of their time.
A test is known by what it does, so that no list of names is kept.
"""

import sys
import threading
from collections.abc import Iterator

import pytest

STARTS = {
    "subprocess.Popen",
    "os.fork",
    "os.forkpty",
    "os.posix_spawn",
    "os.system",
    "os.exec",
    "socket.bind",
}
"""Audit events of Python (docs.python.org, "Audit events table")."""

_asked: list[str] = []


def _watch(event: str, arguments: tuple[object, ...]) -> None:
    if event == "os.kill" and threading.current_thread() is not threading.main_thread():
        raise SystemExit  # ends the thread: the test that it was to interrupt has been skipped
    if event in STARTS and _asked:
        pytest.skip(f"{event}: asks more than this process")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    """Watch what the test and its fixtures do, from here on."""
    _asked[:] = [item.nodeid]
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown() -> Iterator[None]:
    """What ends a process may start one."""
    _asked.clear()
    return (yield)


sys.addaudithook(_watch)
