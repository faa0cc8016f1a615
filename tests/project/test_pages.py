"""The pages as a whole: each stands in the navigation once, and all stay short enough to be read."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.pages import PAGES, navigation
from tests.places import DOCS, ROOT

GENERATED = {"index.md", "contributing.md", "changelog.md"}
"""Pages of the site whose text stands in the root of the repository (docs/site.py)."""


ALLOTTED = {
    "autopilot.md": 950,
    "azimuth.md": 600,
    "failures.md": 600,
    "fuse.md": 500,
    "judge-your-allocator.md": 600,
    "problems.md": 460,
    "soft.md": 800,
    "weak-axes.md": 500,
    "what-flies.md": 600,
}
"""Most words of each page that explains one newer subject; the others share one limit."""


def words(page: Path) -> int:
    """Words: text with a letter or a digit; the bars of a table are none."""
    return sum(bool(re.search(r"\w", word)) for word in page.read_text(encoding="utf-8").split())


def test_the_navigation_has_every_page_once() -> None:
    shown = navigation()
    assert sorted(shown) == sorted({*GENERATED, *(page.name for page in DOCS.glob("*.md"))})


def test_pages_without_a_limit_of_their_own_have_at_most_19_900_words() -> None:
    counted = {page.name: words(page) for page in DOCS.glob("*.md") if page.name not in ALLOTTED}
    assert sum(counted.values()) <= 19_900, counted


@pytest.mark.parametrize(
    "page", [page for page in sorted(DOCS.glob("*.md")) if page.name in ALLOTTED], ids=lambda page: page.name
)
def test_a_page_of_one_subject_has_at_most_the_words_that_it_is_allotted(page: Path) -> None:
    assert words(page) <= ALLOTTED[page.name]


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
