"""A section of the report is a function, and stands where a page names it."""

import inspect
from importlib import import_module
from pathlib import Path

import pytest

from alloc.files.modules import modules
from bench.report import sections
from bench.report.sections import facts
from bench.results.rows import Run, read_run
from tests import made_up

page = import_module("bench.report.page")  # a function of this name stands in the package


def test_every_section_has_its_place_on_a_page() -> None:
    written = {
        each
        for module in modules(sections.__name__).values()
        for each in vars(module).values()
        if inspect.isfunction(each) and [*inspect.signature(each).parameters] == ["run", "drawn"]
    }
    assert {*page.FIRST, *page.REST} == written


def test_a_made_up_section_is_shown_where_its_name_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """CONTRIBUTING's row on a section, followed."""

    def made(run: Run, drawn: frozenset[str]) -> str:
        return f"## Made up of {len(run.rows)} rows\n"

    run = read_run(made_up.whole(tmp_path))
    monkeypatch.setattr(page, "REST", (made, facts.method))
    before, shown, after = page.details(run, frozenset()).partition(f"\n## Made up of {len(run.rows)} rows\n")
    assert before.startswith("# The details")
    assert shown
    assert "## How it was measured" in after
