"""README.md, CONTRIBUTING.md and the pages of docs/, for tests that try what the pages show."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from tests.places import DOCS, ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))]
SAVED = re.compile(r"[Ss]aved? (?:\w+ ){0,3}as `([\w./-]+)`")
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def navigation() -> list[str]:
    """The pages of the site in the order that mkdocs.yml writes out."""

    def pages(entry: Any) -> Iterator[str]:
        if isinstance(entry, str):
            yield entry
        else:
            for inner in entry.values() if isinstance(entry, dict) else entry:
                yield from pages(inner)

    settings = YAML(typ="safe").load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    return list(pages(settings["nav"]))


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of one language, in order; language "" for blocks that name none."""
    return [body for name, body in FENCE.findall(page.read_text(encoding="utf-8")) if name == language]


def saved(page: Path, folder: Path) -> None:
    """Write the blocks that a page tells to save, each under the name that stands in the prose before it."""
    text = page.read_text(encoding="utf-8")
    names = [(match.start(), match[1]) for match in SAVED.finditer(text)]
    files = [block for block in FENCE.finditer(text) if block[1] in ("yaml", "csv", "python", "py")]
    for at, name in names:
        # The block that follows the sentence, or the one right before it ("Save the demands as …").
        after = next((block for block in files if block.start() > at), None)
        before = next((block for block in reversed(files) if block.end() < at), None)
        block = after if after is not None and after.start() - at < 200 else before
        assert block is not None, f"{page.name}: nothing to save as {name}"
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(block[2], encoding="utf-8")
