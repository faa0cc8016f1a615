"""README.md, CONTRIBUTING.md and what stands in docs/, for tests that try what the pages show."""

import re
from pathlib import Path

from tests.places import DOCS, ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of one language, in order; "" for those that name none."""
    return [body for found, body in FENCE.findall(page.read_text(encoding="utf-8")) if found == language]
