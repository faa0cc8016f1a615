"""Processors that tests count on, where this machine can emulate them."""

import pytest

from bench.chips.processors import Processor, processor
from bench.chips.toolchain import missing


def available(name: str) -> Processor:
    """The processor of that name; skips the test where its compiler or emulator is missing."""
    known = processor(name)
    if reason := missing(known):
        pytest.skip(reason)
    return known
