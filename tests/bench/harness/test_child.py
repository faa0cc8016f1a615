"""Measured processes start in one environment, and one function says how they ended."""

import signal
import subprocess
import sys

import pytest

from alloc import catalogue
from alloc.discovery import entries_at
from bench.harness import ONE_THREAD, environment
from bench.harness.process import cause


def test_a_measured_process_has_one_thread_whatever_is_set_here(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ONE_THREAD:
        monkeypatch.setenv(name, "7")
    for isolated in (False, True):
        variables = environment(isolated=isolated, PYTHONHASHSEED="3")
        assert {variables[name] for name in ONE_THREAD} == {"1"}
        assert variables["PYTHONHASHSEED"] == "3"


def test_an_isolated_process_inherits_nothing_that_is_set_for_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", "elsewhere")
    monkeypatch.setenv("PYTHONOPTIMIZE", "2")
    assert not [name for name in environment(isolated=True) if name.startswith("PYTHON")]
    assert environment()["PYTHONPATH"].endswith("elsewhere")
    assert environment()["PYTHONOPTIMIZE"] == "2"


@pytest.mark.parametrize(
    ("code", "printed", "words"),
    [
        (-signal.SIGSEGV, b"", "SIGSEGV"),
        (-40, b"", "signal 40"),  # a real-time signal without a name
        (3, b"first\nlast \n\n", "exit code 3: last"),
        (0, b"\xff\n", "exit code 0: \ufffd"),
        (1, b"x" * 999, f"exit code 1: {'x' * 200}"),
    ],
)
def test_a_cause_is_the_signal_or_code_and_the_last_line_printed(
    code: int, printed: bytes, words: str
) -> None:
    assert cause(code, printed) == words


def test_the_suite_asks_for_one_thread_before_numpy_can_start_more() -> None:
    ask = "import os, sys, bench.suite; print('numpy' in sys.modules, os.environ['OPENBLAS_NUM_THREADS'])"
    fresh = {key: value for key, value in environment().items() if key not in ONE_THREAD}
    done = subprocess.run([sys.executable, "-c", ask], env=fresh, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "1"]


@pytest.mark.parametrize("method", ["qp/daqp", "clip"])
def test_a_worker_imports_its_method_and_nothing_that_makes_c(method: str) -> None:
    """Each process of a run read the whole catalogue, in a third of its start."""
    code = "import sys, bench.harness.worker as w; w.find_entry(sys.argv[1], None); print(*sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code, method], capture_output=True, text=True, check=True)
    assert set(ran.stdout.split()).isdisjoint(
        {"alloc.c", "alloc.methods.native", "alloc.methods.redistribute", "email", "xml.sax"}
    )


def test_each_method_of_the_catalogue_is_found_in_the_file_that_its_name_points_to() -> None:
    """Else ``find`` would import all files before it found one."""
    found = {entry.name: {each.name for each in entries_at(entry.name)} for entry in catalogue()}
    assert [name for name, there in found.items() if name not in there] == []
