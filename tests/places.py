"""The project's folders, and the environment of another pytest that a test starts."""

import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"


def other_pytest() -> dict[str, str]:
    """Environment of another pytest: without this one's variables, but with its place for tmp_path."""
    kept = "PYTEST_DEBUG_TEMPROOT"
    return {key: value for key, value in os.environ.items() if key == kept or not key.startswith("PYTEST_")}
