"""README.md, CONTRIBUTING.md and the pages of docs/, for tests that try what the pages show."""

import re
from pathlib import Path

from tests.places import DOCS, ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of one language, in order; language "" for blocks that name none."""
    return [body for name, body in FENCE.findall(page.read_text(encoding="utf-8")) if name == language]
