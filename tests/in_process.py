"""A plugin of pytest, ``-p tests.in_process``: tests that start a process or serve on a socket are skipped.

What remains computes, renders and reads in this process. .ci/elsewhere runs it again under other kernels of
the linear algebra: processes of the others would inherit those, but start and wait for most of their time.
A test is known by what it does, so that no list of names is kept.
"""

import sys
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
    if event in STARTS and _asked:
        pytest.skip(f"{event}: asks more than this process")


def pytest_configure(config: pytest.Config) -> None:
    """A process that is not started leaves its pipes open, which is no fault of a later test."""
    config.addinivalue_line("filterwarnings", "ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    """Watch what the test and its fixtures do, from here on."""
    if "ctrl_c" in getattr(item, "fixturenames", ()):
        pytest.skip("interrupts this process, at a time when another test may run")
    _asked[:] = [item.nodeid]
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown() -> Iterator[None]:
    """The process that ends others may start one."""
    _asked.clear()
    return (yield)


sys.addaudithook(_watch)
