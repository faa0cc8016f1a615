"""The files in results/, README.md are what the committed records give.

A folder in results/ is a committed run where its record is packed.
"""

import gzip
import re
import shutil
from pathlib import Path

import pytest

from bench.record import FILE_NAME, PACKED
from bench.report import render
from bench.report.page import END, START, result_table
from bench.results.rows import read_run
from tests.places import ROOT
from tests.renderings import differences

COMMITTED = sorted(path.parent for path in (ROOT / "results").glob(f"*/{PACKED}"))
REMADE = "report.html"  # not committed: it holds the pictures once more, and `thrustbench report` remakes it
TIMED = [directory for directory in COMMITTED if (directory / "results.csv").exists()]
"""Committed runs with times: runs of emulated processors have instructions only."""

needs_results = pytest.mark.skipif(
    not COMMITTED, reason="no results are committed yet: `make bench`, `make keep`"
)


@needs_results
@pytest.mark.parametrize("pictures", [False, pytest.param(True, marks=pytest.mark.long)], ids=["text", "all"])
@pytest.mark.parametrize("directory", COMMITTED, ids=lambda path: path.name)
def test_a_committed_report_shows_what_its_record_renders(
    directory: Path, pictures: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pictures take ten times as long as all the rest."""
    shutil.copy(directory / PACKED, tmp_path)
    if not pictures:
        drawn = frozenset(path.name for path in directory.glob("*.svg"))
        monkeypatch.setattr("bench.report.draw_all", lambda *_: drawn)
    render(tmp_path)
    left_out = (REMADE, FILE_NAME, PACKED, ".lock")
    made, kept = (
        {
            path.name: path.read_text(encoding="utf-8")
            for path in folder.iterdir()
            if path.name not in left_out and (pictures or path.suffix != ".svg")
        }
        for folder in (tmp_path, directory)
    )
    assert sorted(made) == sorted(kept)
    found = {name: differences(made[name], kept[name], name.endswith(".svg")) for name in made}
    assert {name: what for name, what in found.items() if what} == {}


@pytest.mark.parametrize(
    ("change", "other"),
    [
        (("1.26", "1.27"), False),
        (("1.26", "1.28"), True),
        (("40 calls", "41 calls"), True),
        (("pinv", "svd"), True),
        (("3e-12", "4e-12"), False),
        (("3e-12", "3e-11"), True),
        (("\n| svd", "\n\n| svd"), True),
    ],
    ids=str,
)
def test_a_table_differs_by_words_counts_and_more_than_its_last_digit(
    change: tuple[str, str], other: bool
) -> None:
    table = "| pinv | 40 calls | 1.26 |\n| svd | 9 calls | 3e-12 |\n"
    assert bool(differences(table.replace(*change), table)) == other


@pytest.mark.parametrize(
    ("change", "other"),
    [
        (("10.5", "10.500001"), False),
        (("10.5", "10.6"), True),
        (("mab12", "mcd34"), False),
        (('"#mab12" x="3"', '"#p9" x="3"'), True),
        (("L 4 5", ""), True),
        (("#0072b2", "#d55e00"), True),
        (("<g/>", ""), True),
    ],
    ids=str,
)
def test_a_picture_differs_by_elements_words_and_more_than_a_hundredth_of_a_pixel(
    change: tuple[str, str], other: bool
) -> None:
    picture = (
        '<svg><path id="mab12" d="M 10.5 2 L 4 5"/><path id="p9" style="fill: #0072b2"/><g/>'
        '<use href="#mab12" x="3"/><use href="#p9" x="3"/></svg>'
    )
    assert bool(differences(picture.replace(*change), picture, svg=True)) == other


ABSOLUTE = re.compile(r"(?:(?<![\w./~*)\]}])|(?<=file://)|(?<=\s-[A-Z]))/[\w.~][^\s/\"'`|<>]*/")
"""A path from a machine's root with a folder in it; no quotient, no address, no path inside the tree."""


@pytest.mark.parametrize(
    "path", ["/{}/a.py", "in '/{}/a'", "CC=/{}/cc", ".:/{}/b", "file:///{}/a", "cc -I/{}/c"]
)
@pytest.mark.parametrize("folder", ["home", "root", "tmp", "Users", "opt/x.y", "mnt/~a"])
def test_a_path_from_the_root_is_told_from_others(path: str, folder: str) -> None:
    assert ABSOLUTE.search(path.format(folder))
    for other in (f"docs/{folder}/a.md", f"../{folder}/a", f"https://a.org/{folder}/a", f"N/m/{folder}/s"):
        assert not ABSOLUTE.search(other)


@needs_results
@pytest.mark.parametrize("directory", COMMITTED, ids=lambda path: path.name)
def test_a_committed_report_names_no_path_of_the_machine_it_was_made_on(directory: Path) -> None:
    # The page that `make keep` leaves beside them is not committed.
    kept = [path for path in directory.iterdir() if path.name not in (PACKED, "report.html")]
    texts = [path.read_text(encoding="utf-8") for path in kept]
    for text in (gzip.decompress((directory / PACKED).read_bytes()).decode(), *texts):
        assert ABSOLUTE.findall(text) == []


@pytest.mark.skipif(not TIMED, reason="no timed results are committed yet: `make bench`, `make keep`")
def test_the_readme_s_table_is_the_one_that_a_committed_record_gives() -> None:
    shown = (ROOT / "README.md").read_text(encoding="utf-8").partition(START)[2].partition(END)[0].strip()
    tables = [result_table(read_run(directory)).strip() for directory in TIMED]
    assert not all(differences(table, shown) for table in tables)
