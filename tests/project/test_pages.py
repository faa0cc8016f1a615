"""The pages as a whole: each stands in the navigation once, and all stay short enough to be read."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.pages import PAGES, navigation
from tests.places import DOCS, ROOT

GENERATED = {"index.md", "contributing.md", "changelog.md"}
"""Pages of the site whose text stands in the root of the repository (docs/site.py)."""


def words(page: Path) -> int:
    """Words: text with a letter or a digit; the bars of a table are none."""
    return sum(bool(re.search(r"\w", word)) for word in page.read_text(encoding="utf-8").split())


def test_the_navigation_has_every_page_once() -> None:
    shown = navigation()
    assert sorted(shown) == sorted({*GENERATED, *(page.name for page in DOCS.glob("*.md"))})


def test_all_pages_together_have_at_most_20_000_words() -> None:
    counted = {page.name: words(page) for page in DOCS.glob("*.md")}
    assert sum(counted.values()) <= 20_000, counted


@pytest.mark.parametrize(("page", "most"), [("docs/solvers.md", 1_500), ("CHANGELOG.md", 500)])
def test_a_page_that_used_to_grow_has_a_limit_of_words(page: str, most: int) -> None:
    assert words(ROOT / page) <= most


def test_the_readme_has_at_most_150_lines() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150


def headings(text: str) -> Iterator[str]:
    return (line for line in text.splitlines() if line.startswith("# "))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_has_one_title_and_says_what_it_is_about_before_its_first_section(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    fenced = "".join(text.split("```")[::2])
    assert len(list(headings(fenced))) == 1
    assert len(text.partition("\n## ")[0].split()) >= 15
