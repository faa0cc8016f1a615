"""The commit of the source that a run records, and the core that it leaves to workers."""

import os
from pathlib import Path
from threading import Event, Thread

import psutil
import pytest

from bench.harness import counters, machine
from gate_check import git


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with both packages in it, which ``machine`` takes for this project's own."""
    for name in ("alloc", "bench"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("")
    git(tmp_path, "init", "--quiet")
    git(tmp_path, "add", "--all")
    git(tmp_path, "commit", "--quiet", "--message", "all")
    monkeypatch.setattr(machine, "_ROOT", tmp_path)
    return tmp_path


def test_the_commit_is_the_source_s_and_results_beside_it_do_not_change_it(source: Path) -> None:
    head = git(source, "rev-parse", "--short=12", "HEAD")
    assert machine.commit() == head
    (source / "results").mkdir()
    (source / "results" / "results.csv").write_text("")
    assert machine.commit() == head  # else --resume would refuse the record


@pytest.mark.parametrize("changed", ["alloc/__init__.py", "bench/new.py"])
def test_the_commit_of_a_changed_source_says_so(source: Path, changed: str) -> None:
    (source / changed).write_text("x = 1\n")
    assert machine.commit() == git(source, "rev-parse", "--short=12", "HEAD") + "+changes"


def test_a_source_installed_inside_somebody_else_s_repository_has_no_commit(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed = source / "venv"
    (source / ".gitignore").write_text("venv\n")
    (installed / "alloc").mkdir(parents=True)
    monkeypatch.setattr(machine, "_ROOT", installed)
    assert machine.commit() == ""


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="this system pins nothing")
def test_every_thread_keeps_off_the_workers_core_inside_the_block_and_comes_back() -> None:
    allowed, core, end = os.sched_getaffinity(0), machine.core(), Event()
    other = Thread(target=end.wait)  # like the thread that draws the progress bar
    other.start()
    try:
        with machine.reserve_core():
            places = [os.sched_getaffinity(thread.id) for thread in psutil.Process().threads()]
        assert len(places) >= 2
        assert all(place == (allowed - {core} or allowed) for place in places)
        assert os.sched_getaffinity(other.native_id or 0) == allowed
    finally:
        end.set()
        other.join()
    assert os.sched_getaffinity(0) == allowed


@pytest.mark.skipif(not psutil.LINUX, reason="only Linux says which time was stolen")
def test_stolen_time_is_what_psutil_reads_of_that_core() -> None:
    for core in os.sched_getaffinity(0):
        before, ticks, after = (read(core) for read in (_stolen, counters._steal, _stolen))
        assert ticks is not None
        assert round(before) <= ticks <= round(after)


def _stolen(core: int) -> float:
    steal: float = psutil.cpu_times(percpu=True)[core].steal
    return 100 * steal  # psutil has seconds, /proc/stat hundredths of one
