"""Runs of these tests draw no pictures: they show what a run measures, and pictures take half its time."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.results.rows import Run


def _none(run: Run, directory: Path) -> frozenset[str]:
    return frozenset()


@pytest.fixture(autouse=True, scope="module")  # as wide as the widest fixture here that makes a run
def without_pictures() -> Iterator[None]:
    """Reports of runs made within this process have no pictures; those of other processes have theirs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bench.report.draw_all", _none)
        yield
