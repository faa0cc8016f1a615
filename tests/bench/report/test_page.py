"""A section of the report is one file, and its name in the order of a page."""

import sys
from pathlib import Path

import pytest

from alloc.files import modules
from bench.report import sections
from bench.report.page import FIRST, REST, SECTIONS, details
from bench.results.rows import read_run
from tests import made_up


def test_every_section_has_its_place_on_a_page() -> None:
    assert {*FIRST, *REST} == set(modules.names(SECTIONS))


def test_a_made_up_section_is_shown_where_its_name_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """CONTRIBUTING's row on a section, followed."""
    run = read_run(made_up.whole(tmp_path))
    (tmp_path / "made_up.py").write_text(
        "def section(run, drawn):\n    return f'## Made up of {len(run.rows)} rows\\n'\n", encoding="utf-8"
    )
    monkeypatch.setattr(sections, "__path__", [*sections.__path__, str(tmp_path)])
    monkeypatch.setattr(sys.modules["bench.report.page"], "REST", ("made-up", "method"))
    try:
        text = details(run, frozenset())
    finally:
        sys.modules.pop(f"{SECTIONS}.made_up", None)
    before, shown, after = text.partition(f"\n## Made up of {len(run.rows)} rows\n")
    assert before.startswith("# The details")
    assert shown
    assert "## How it was measured" in after
