"""A browser for tests of pages, and why there is none."""

import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")


@contextmanager
def browser() -> Iterator[Any]:
    """Playwright's Chromium where it was installed, else the system's; skips the test where neither is."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if "tests.in_process" in sys.modules:  # Playwright's own loop would swallow the skip
        pytest.skip("a browser is another process")
    with sync_api.sync_playwright() as playwright:
        own = playwright.chromium.executable_path
        path = own if Path(own).exists() else next(filter(None, map(shutil.which, NAMES)), None)
        if path is None:
            pytest.skip("there is no Chromium here (apt install chromium)")
        launched = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            yield launched
        finally:
            launched.close()
