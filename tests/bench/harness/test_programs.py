"""A program's row is judged and timed like others, the pipe's own time beside it."""

import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from alloc.c.compiled import missing
from bench.__main__ import cli
from bench.record import read
from bench.results.rows import read_run
from tests.alloc.foreign.test_foreign import FOREIGN, compiled
from tests.alloc.foreign.test_program import START, WRONG, script

TINY = ["--vehicle=ukwial", "--demands=inactive", "--n=4", "--budget-ms=1", "--repeats=1"]


def test_a_program_has_a_row_and_one_that_exits_another(tmp_path: Path, bare_runs: None) -> None:
    methods = [str(script(tmp_path, WRONG["exits"][0], "exits")), f"exec:{sys.executable} {START}", "clip"]
    words = ["run", *(f"--method={name}" for name in methods), *TINY, f"--out={tmp_path}"]
    done = CliRunner().invoke(cli, words, standalone_mode=False)
    assert done.return_value == 0, done.output
    rows = {row.method: row for row in read_run(tmp_path).rows}
    (mine,) = (row for name, row in rows.items() if name.endswith("my_allocator"))
    assert (mine.status, mine.wrong, rows["clip"].status) == ("ok", "", "ok")
    assert mine.lost_wrench_max == pytest.approx(rows["clip"].lost_wrench_max, abs=1e-9)
    assert mine.way_in_p50_us is not None
    assert mine.call_p50_us is not None
    assert 0 < mine.way_in_p50_us < mine.call_p50_us
    assert rows["clip"].way_in_p50_us is None
    assert rows["exits"].status == "failed"
    assert "ended with exit code 4 in place of an answer" in rows["exits"].reason
    assert f"{mine.method}: the way in takes " in done.output
    assert f"{mine.method}: the way in takes " in (tmp_path / "report.md").read_text()


CONDUCT = {
    "remembers": (
        "last = []",
        "last.append(f); f = [a + (len(last) % 2) for a in f]",
        "depends on earlier calls",
    ),
    "leaks": (
        "kept = []",
        "kept.append(b'x' * (50000 + len(kept)))",
        "its memory grows by [0-9,]+ MB in a million",
    ),
    "threads": (
        "import threading, time",
        "threading.Thread(target=time.sleep, args=(99,), daemon=True).start()",
        "its calls leave threads behind",
    ),
    "calm": ("last = 0.0", "last = f[0]", "^$"),
}


@pytest.mark.long
def test_each_misconduct_of_a_program_is_named(tmp_path: Path, bare_runs: None) -> None:
    at, before = "    say([min(", 'say({"thrustbench"'
    words = ["run", *TINY, f"--out={tmp_path}"]
    for name, (first, each, _) in CONDUCT.items():
        text = START.read_text().partition("\n")[2]
        text = text.replace(at, f"    {each}\n{at}").replace(before, f"{first}\n{before}")
        words.append(f"--method={script(tmp_path, text, name)}")
    CliRunner().invoke(cli, words, standalone_mode=False)
    rows = {row.method: row for row in read_run(tmp_path).rows}
    for name, (_, _, says) in CONDUCT.items():
        assert re.search(says, rows[name].wrong or rows[name].reason), (name, rows[name].wrong)


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
def test_the_way_to_a_library_is_timed(tmp_path: Path, bare_runs: None) -> None:
    text = (FOREIGN / "starters/c/my_allocator.c").read_text(encoding="utf-8")
    library = compiled(tmp_path, text, "-O2")
    done = CliRunner().invoke(
        cli, ["run", f"--method={library}", *TINY, f"--out={tmp_path}"], standalone_mode=False
    )
    assert done.return_value == 0, done.output
    (cell,) = (cell for cell in read(tmp_path).cells if cell.key.method == "mine")
    assert cell.way_in_batches
