"""Ctrl-C, SIGTERM and SIGKILL end a run in order: no worker and no folder is left, and the record says it."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil
import pytest

from bench.harness.plan import RunSettings
from bench.harness.run import WORKING, Interrupted, run
from bench.harness.state import Progress
from bench.record import read
from tests.places import ROOT
from tests.plugin_files import write_plugin
from tests.runs import started, wait_for, written

LOOPS = """
import os
from pathlib import Path

def build(vehicle):
    def allocate(tau):
        Path({file!r}).with_suffix(".part").write_text(str(os.getpid()))
        Path({file!r}).with_suffix(".part").rename({file!r})
        while True:
            pass
    return allocate
"""
"""A plain function that leaves its process's number before it loops."""


def test_a_worker_dies_with_its_parent_even_in_an_endless_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))  # a run that is killed before it has a folder leaves its case
    (tmp_path / "loops.py").write_text(LOOPS.format(file=str(tmp_path / "looping")))
    command = [
        "run",
        "--vehicle=ukwial",
        "--demands=infeasible",
        f"--plugin={tmp_path / 'loops.py'}",
        "--n=4",
    ]
    with started("-m", "bench", *command, f"--out={tmp_path / 'out'}") as run:
        wait_for((tmp_path / "looping").exists)
        (worker,) = psutil.Process(run.pid).children()
        assert str(worker.pid) == (tmp_path / "looping").read_text()
        run.kill()
    wait_for(lambda: not worker.is_running() or worker.status() == psutil.STATUS_ZOMBIE)


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_stops_the_worker_and_reports_what_there_is(tmp_path: Path) -> None:
    plugin = write_plugin(tmp_path, "sleeps")
    command = ["run", "--vehicle=ukwial", "--demands=inactive", f"--plugin={plugin}", "--budget-ms=2000"]
    command += ["--time-limit=4"]  # so that the share of so slow a method is soon given up
    out = tmp_path / "out"
    with started("-m", "bench", *command, f"--out={out}") as run:
        wait_for(lambda: b'"cell"' in written(out))
        (worker,) = psutil.Process(run.pid).children() or [None]
        run.send_signal(signal.SIGINT)
        output = run.communicate()[0].decode()
    assert run.returncode == 130, output
    assert "Traceback" not in output
    assert "--resume" in output
    assert (out / "report.md").is_file()
    assert read(out).events[-1].what == "interrupted"
    assert worker is None or not worker.is_running()


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_while_a_plug_in_hangs_in_its_import_ends_the_run_before_it_writes_anything(
    tmp_path: Path,
) -> None:
    (tmp_path / "hangs.py").write_text("while True: pass\n")
    out = tmp_path / "out"
    with started("-m", "bench", "run", f"--plugin={tmp_path / 'hangs.py'}", f"--out={out}") as run:
        wait_for(psutil.Process(run.pid).children)
        workers = psutil.Process(run.pid).children()
        run.send_signal(signal.SIGINT)
        output = run.communicate()[0].decode()
    assert run.returncode == 130, output
    assert "Traceback" not in output
    assert not [worker for worker in workers if worker.is_running()]
    assert not out.exists()


def test_sigterm_ends_a_run_and_leaves_no_worker_and_no_temporary_folder(tmp_path: Path) -> None:
    plugin = write_plugin(tmp_path, "loops")
    place = tmp_path / "temporary"
    place.mkdir()
    command = ["run", "--vehicle=ukwial", "--demands=infeasible", f"--plugin={plugin}", "--n=4"]
    command += ["--time-limit=1"]  # so that its share, which comes first, is soon given up
    arguments = [sys.executable, "-m", "bench", *command, f"--out={tmp_path / 'out'}"]
    with subprocess.Popen(
        arguments, cwd=ROOT, env={**os.environ, "TMPDIR": str(place)}, stdout=subprocess.PIPE
    ) as run:
        wait_for(lambda: b'"cell"' in written(tmp_path / "out"))
        workers = psutil.Process(run.pid).children()
        assert list((tmp_path / "out").glob(f"{WORKING}*"))
        run.terminate()
        run.communicate()
    assert run.returncode == 128 + signal.SIGTERM
    assert not [worker for worker in workers if worker.is_running()]
    assert not [*place.iterdir(), *(tmp_path / "out").glob(f"{WORKING}*")]


def interrupted(folder: Path, watch: Callable[[Progress], None]) -> None:
    """Run until Ctrl-C comes; no worker may be left, not even while Interrupted is being handled."""
    mine = psutil.Process()
    before = set(mine.children())
    settings = RunSettings(
        vehicles=("ukwial",),
        demands=("inactive",),
        methods=("pinv", "svd"),
        n_demands=4,
        budget_ms=0,
        repeats=1,
    )
    try:
        run(settings, folder, resume=False, watch=watch)
    except Interrupted:
        assert set(mine.children()) == before
    else:
        pytest.fail("Ctrl-C was lost")
    assert read(folder).events[-1].what == "interrupted"


@pytest.mark.usefixtures("ctrl_c", "bare_runs")
def test_ctrl_c_between_two_results_leaves_no_worker(tmp_path: Path) -> None:
    def stop(progress: Progress) -> None:
        if progress.done == 2:
            signal.raise_signal(signal.SIGINT)

    interrupted(tmp_path, stop)


@pytest.mark.usefixtures("ctrl_c", "bare_runs")
def test_ctrl_c_while_a_worker_is_being_started_leaves_no_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = subprocess.Popen.__init__

    def interrupted_start(self: Any, command: list[str], **named: Any) -> None:
        start(self, command, **named)
        if "bench.harness.worker" in command:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(subprocess.Popen, "__init__", interrupted_start)
    interrupted(tmp_path, lambda progress: None)
