"""The site that ``make docs`` builds, in a browser as wide as a desk's window and as a phone."""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from tests.browsers import browser
from tests.places import ROOT

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(find_spec("mkdocs") is None, reason="mkdocs is not installed: the extra docs"),
]

WIDTHS = (1400, 390)
"""Widths of a desk's window and of a phone [px]."""
BEYOND = """() => {
    document.querySelectorAll("details").forEach(one => one.open = true);
    const told = element => `${element.tagName} ${element.innerText.slice(0, 60)}`;
    const all = [...document.querySelectorAll(".md-content *, main *, details *")];
    const wide = all.filter(one => !one.closest("svg") && one.getBoundingClientRect().right > innerWidth + 1);
    const scrolls = [...document.querySelectorAll("table")].filter(table =>
        [table, table.parentElement].some(one => one.scrollWidth > one.clientWidth));
    return [...new Set([...wide, ...scrolls])].map(told);
}"""
"""Elements that end right of the window, and tables that are wider than their box."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built site."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(folder)]
    quiet = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    built = subprocess.run(command, cwd=ROOT, env=quiet, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr
    return folder


def beyond(opened: Any) -> dict[int, list[str]]:
    """Elements that do not fit at each width; nothing where all do."""
    found = {}
    for width in WIDTHS:
        opened.set_viewport_size({"width": width, "height": 844})
        if wide := opened.evaluate(BEYOND):
            found[width] = wide
    return found


def test_no_page_has_a_table_or_anything_else_that_is_wider_than_the_window(site: Path) -> None:
    with browser() as chromium:
        opened = chromium.new_page()
        pages = {str(page.relative_to(site)): page for page in site.rglob("*.html")}
        assert len(pages) > 40
        wide = {}
        for name, page in sorted(pages.items()):
            opened.goto(page.as_uri())
            if found := beyond(opened):
                wide[name] = found
        assert wide == {}


def test_a_table_that_is_too_wide_for_a_phone_is_found_and_one_that_fits_is_not() -> None:
    row = "".join(f"<td>{'9' * 12}</td>" for _ in range(5))
    with browser() as chromium:
        opened = chromium.new_page()
        opened.set_content(f"<main><div style='overflow: auto'><table><tr>{row}</tr></table></div></main>")
        assert list(beyond(opened)) == [390]


@pytest.mark.parametrize("word", ["PWM", "saturation", "thruster failure", "Cortex-M4", "ROS"])
def test_what_readers_search_for_is_in_the_index_of_the_search(site: Path, word: str) -> None:
    index = json.loads((site / "search/search_index.json").read_text(encoding="utf-8"))
    places = [page for page in index["docs"] if word.lower() in f"{page['title']} {page['text']}".lower()]
    assert places
