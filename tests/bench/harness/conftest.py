"""Runs of these tests draw no pictures: they show what a run measures, and pictures take half its time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from bench.harness.timing import NOOP, YARDSTICKS
from bench.record import Capability
from bench.results.rows import Run


def _no_pictures(run: Run, directory: Path) -> frozenset[str]:
    return frozenset()


def _no_capabilities(*_: Any) -> list[Capability]:
    return []


@pytest.fixture(autouse=True, scope="module")  # as wide as the widest fixture here that makes a run
def without_pictures() -> Iterator[None]:
    """Reports of runs made within this process have no pictures; those of other processes have theirs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bench.report.draw_all", _no_pictures)
        yield


@pytest.fixture(scope="module")
def bare_runs() -> Iterator[None]:
    """Runs made within this process measure cells only, no share of what vehicles can do, and no canary.

    Each of those takes a process; test_run.py, test_misbehaviour.py and others make runs that are whole.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bench.harness.run.measure_capabilities", _no_capabilities)
        for module in ("plan", "run"):
            patch.setattr(f"bench.harness.{module}.YARDSTICKS", {NOOP: YARDSTICKS[NOOP]})
        yield
