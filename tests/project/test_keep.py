"""`make keep` puts a run into results/, to be committed, and touches nothing else."""

import gzip
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bench.record import PACKED
from bench.report.page import END, START
from tests.made_up import whole
from tests.places import ROOT

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A project that is set up, with a README that shows no results yet."""
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, tmp_path)
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "bin").symlink_to(Path(sys.executable).parent)
    (tmp_path / ".venv" / "lean").touch()
    (tmp_path / "README.md").write_text(f"{START}\n{END}\n")
    return tmp_path


def measured(tree: Path, name: str) -> bytes:
    """Put a run with a row of times into runs/; returns the bytes of its record."""
    folder = tree / "runs" / name
    folder.mkdir(parents=True)
    (folder / "results.csv").touch()
    return (whole(folder) / "record.jsonl").read_bytes()


def keep(tree: Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = ["make", "--no-print-directory", "keep", *options]
    clean = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
    return subprocess.run(command, cwd=tree, capture_output=True, text=True, check=False, env=clean)


def test_a_single_run_is_packed_reported_and_shown_in_the_readme(tree: Path) -> None:
    record = measured(tree, "board")
    stale = tree / "results" / "board" / "cost-gone.svg"
    stale.parent.mkdir(parents=True)
    stale.touch()
    done = keep(tree)
    assert done.returncode == 0, done.stderr
    kept = tree / "results" / "board"
    assert gzip.decompress((kept / PACKED).read_bytes()) == record
    assert (kept / "report.md").is_file()
    assert not stale.exists()
    assert "`pinv`" in (tree / "README.md").read_text()
    assert sorted(path.name for path in (tree / "runs" / "board").iterdir()) == [
        "record.jsonl",
        "results.csv",
    ]


def test_make_keep_without_a_run_fails_with_one_line(tree: Path) -> None:
    done = keep(tree)
    assert done.returncode != 0
    assert "no run in runs/; `make bench` makes one" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (tree / "results").exists()


def test_make_keep_takes_the_run_that_is_named_among_several(tree: Path) -> None:
    for name in ("board", "emulated"):
        measured(tree, name)
    done = keep(tree)
    assert done.returncode != 0
    assert "make keep RUN=... with one of " in done.stderr
    assert "runs/board" in done.stderr
    assert not (tree / "results").exists()
    (tree / "runs" / "emulated" / "results.csv").unlink()
    before = (tree / "README.md").read_text()
    assert keep(tree, "RUN=runs/emulated/").returncode == 0
    assert [path.name for path in (tree / "results").iterdir()] == ["emulated"]
    assert (tree / "README.md").read_text() == before, "a run without times has no result table"
