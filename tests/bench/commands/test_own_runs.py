"""One's own results: a folder for each run, the latest where none is named, nothing replaced in silence."""

import os
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from bench.__main__ import cli
from bench.commands import RUNS, latest_run
from bench.record import RecordError
from bench.report import render
from tests.made_up import whole

TINY = ("--vehicle=ukwial", "--demands=inactive", "--method=pinv", "--n=4", "--budget-ms=0", "--repeats=1")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def unmeasured(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs that write a record's header and events, and a report: what they measure decides no folder."""
    monkeypatch.setattr("bench.harness.run.prepare", lambda *_: None)
    monkeypatch.setattr("bench.harness.run.groups", lambda *_: [])


def thrustbench(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments, standalone_mode=False)


def measured(name: str, age_s: int) -> Path:
    """A made-up run under runs/, written so many seconds ago."""
    folder = RUNS / "board" / name
    folder.mkdir(parents=True)
    record = whole(folder) / "record.jsonl"
    then = record.stat().st_mtime - age_s
    os.utime(record, (then, then))
    return folder


@pytest.mark.usefixtures("unmeasured")
def test_each_run_has_a_folder_of_its_own_and_resume_goes_on_with_the_latest(here: Path) -> None:
    assert thrustbench("run", *TINY).return_value == 0
    first = latest_run()
    assert thrustbench("run", *TINY).return_value == 0
    second = latest_run()
    assert first != second
    assert first.parent == second.parent
    before = (first / "record.jsonl").read_bytes()
    assert thrustbench("run", *TINY, "--resume").return_value == 0
    assert (first / "record.jsonl").read_bytes() == before
    assert '"resumed"' in (second / "record.jsonl").read_text()
    assert len(list(first.parent.iterdir())) == 2


@pytest.mark.parametrize("command", [("report",), ("size", "--rate", "100")])
def test_report_and_size_take_the_latest_run(command: tuple[str, ...], here: Path) -> None:
    measured("new", 10)
    measured("old", 99)
    assert latest_run() == RUNS / "board" / "new"
    assert thrustbench(*command).exception is None
    assert (RUNS / "board" / "new" / "report.md").is_file() == (command[0] == "report")
    assert not (RUNS / "board" / "old" / "report.md").exists()


def test_without_any_run_the_command_that_makes_one_is_named() -> None:
    with pytest.raises(RecordError, match="holds no run; `thrustbench run` makes one"):
        latest_run()
    assert isinstance(thrustbench("report").exception, RecordError)


@pytest.mark.usefixtures("unmeasured")
def test_every_earlier_record_of_a_named_folder_is_kept_and_said(here: Path) -> None:
    records = []
    for seed in range(3):
        done = thrustbench("run", *TINY, f"--seed={seed}", "--out=mine")
        assert ("the earlier run's record is kept" in done.output) == (seed > 0)
        records.append((here / "mine" / "record.jsonl").read_bytes())
    kept = [here / "mine" / f"record.{name}.jsonl" for name in ("previous", "previous-2")]
    assert [path.read_bytes() for path in kept] == [records[1], records[0]]


def test_pictures_of_an_earlier_run_go_and_a_user_s_own_stay(here: Path) -> None:
    folder = measured("new", 0)
    for name in ("cost-another-vehicle.svg", "growth.svg", "my-rov.svg"):
        (folder / name).write_text("<svg/>")
    render(folder)
    names = {path.name for path in folder.glob("*.svg")}
    assert "my-rov.svg" in names
    assert not names & {"cost-another-vehicle.svg", "growth.svg"}
