"""What tests of readers share: a file as it was sent, and how it is refused."""

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
    """The message with which ``read`` refuses: it comes soon and is one line that names the file."""
    start = time.process_time()  # a busy machine is not the reader's fault
    with pytest.raises(AllocError) as caught:
        read()
    message = str(caught.value)
    assert time.process_time() - start < 5
    assert "\n" not in message
    assert message.startswith(str(path))
    return message
