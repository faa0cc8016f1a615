"""The files in results/, README.md and docs/results.md are what the committed records give.

A folder in results/ is a committed run where its record is packed.
"""

import gzip
import shutil
from pathlib import Path

import pytest

from bench.record import FILE_NAME, PACKED
from bench.report import render
from bench.report.readme import END, START, result_table
from bench.results.rows import read_run
from bench.results.table import documentation
from tests.places import ROOT

COMMITTED = sorted(path.parent for path in (ROOT / "results").glob(f"*/{PACKED}"))
REMADE = "report.html"  # not committed: it holds the pictures once more, and `thrustbench report` remakes it
TIMED = [directory for directory in COMMITTED if (directory / "results.csv").exists()]
"""Committed runs with times: runs of emulated processors have instructions only."""

needs_results = pytest.mark.skipif(
    not COMMITTED, reason="no results are committed yet: `make bench`, `make keep`"
)


@needs_results
@pytest.mark.parametrize("directory", COMMITTED, ids=lambda path: path.name)
def test_a_committed_report_is_what_its_record_renders_byte_for_byte(directory: Path, tmp_path: Path) -> None:
    shutil.copy(directory / PACKED, tmp_path)
    render(tmp_path)
    made = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.name != REMADE}
    left_out = (REMADE, FILE_NAME, ".lock")
    kept = {path.name: path.read_bytes() for path in directory.iterdir() if path.name not in left_out}
    assert sorted(made) == sorted(kept)
    assert [name for name in made if made[name] != kept[name]] == []


@needs_results
@pytest.mark.parametrize("directory", COMMITTED, ids=lambda path: path.name)
def test_a_committed_report_names_no_path_of_the_machine_it_was_made_on(directory: Path) -> None:
    record = gzip.decompress((directory / PACKED).read_bytes()).decode()
    text = record + (directory / "report.md").read_text(encoding="utf-8")
    assert not [place for place in ("/home/", "/root/", "/tmp/", "/work/", "/Users/") if place in text]


@pytest.mark.skipif(not TIMED, reason="no timed results are committed yet: `make bench`, `make keep`")
def test_the_readme_s_table_is_the_one_that_a_committed_record_gives() -> None:
    shown = (ROOT / "README.md").read_text(encoding="utf-8").partition(START)[2].partition(END)[0]
    assert shown.strip() in [result_table(read_run(directory)).strip() for directory in TIMED]


def test_docs_results_md_documents_the_columns() -> None:
    text = (ROOT / "docs/results.md").read_text(encoding="utf-8")
    shown = text.partition("<!-- columns:start -->\n")[2].partition("<!-- columns:end -->")[0]
    assert shown == documentation(), "put what `thrustbench columns` prints between the markers"
