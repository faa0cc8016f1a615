"""Helpers for tests of readers: a file is written, and its refusal is caught."""

import time
from collections.abc import Callable
from pathlib import Path

import pytest

from alloc import AllocError


def written(file: Path, text: str | bytes) -> Path:
    """The file, holding that text."""
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return file


def refused(read: Callable[[], object], path: Path) -> str:
    """The message with which ``read`` refuses; it comes within 5 s, in one line that starts with the path."""
    start = time.process_time()  # a busy machine is not the reader's fault
    with pytest.raises(AllocError) as caught:
        read()
    message = str(caught.value)
    assert time.process_time() - start < 5
    assert "\n" not in message
    assert message.startswith(str(path))
    return message
