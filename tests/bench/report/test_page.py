"""A section of the report is a function, and stands where a page names it."""

import inspect
from pathlib import Path

import pytest

from alloc.files.modules import modules
from bench.report import page, sections
from bench.report.sections import facts
from bench.results.rows import Run, read_run
from tests import made_up


def test_every_section_has_its_place_on_a_page() -> None:
    functions = [each for module in modules(sections.__name__).values() for each in vars(module).values()]
    made = {
        each
        for each in functions
        if inspect.isfunction(each) and each.__module__.startswith(sections.__name__)
    }
    assert {*page.FIRST, *page.REST} == {
        each for each in made if [*inspect.signature(each).parameters] == ["run", "drawn"]
    }


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
