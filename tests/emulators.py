"""Processors that tests count on, where this machine can emulate them."""

import pytest

from bench.chips.target import Target, target
from bench.chips.toolchain import missing


def available(name: str) -> Target:
    """The target of that name; skips the test where its compiler or emulator is missing."""
    known = target(name)
    if reason := missing(known):
        pytest.skip(reason)
    return known
