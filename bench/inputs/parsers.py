"""Other projects' parsers of logs: what they raise at damaged bytes; PX4's, for two kinds of log."""

from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
from textwrap import shorten
from typing import Any

from alloc import AllocError
from alloc.errors import FileError, NotInstalled


@contextmanager
def parsing(path: Path, what: str, library: str) -> Iterator[None]:
    """Raise FileError for whatever a parser raises: at damaged bytes that may be anything."""
    try:
        yield
    except AllocError:
        raise
    except Exception as error:
        said = shorten(f"{type(error).__name__}: {error}", 120, placeholder=" …")
        raise FileError(
            f"{path}: not a {what} that {library} can read ({said}); is it whole? copy it anew"
        ) from None


DAMAGED = "; it is damaged in places, so rows may be missing"
"""What is said of a log of which its parser had to leave something out."""


Instances = dict[int, dict[str, Any]]
"""The columns of each instance of a message that has rows, by the instance's number."""


def read_ulog(path: Path, *messages: str) -> tuple[dict[str, Instances], dict[str, Any], str]:
    """The instances of each of these messages in a ULog, the parameters at its start, and what is odd.

    What is odd is text to be added to what is said of the log, empty for nothing. Raises NotInstalled without
    pyulog, and within ``parsing`` FileError for what is no ULog.
    """
    try:
        from pyulog.core import ULog
    except ImportError:
        raise NotInstalled("reading ULogs needs pyulog; pip install 'thrustbench[px4]'") from None
    # pyulog prints warnings of damaged parts, but standard output is for results.
    with path.open("rb") as file, redirect_stdout(StringIO()):
        log = ULog(file, list(messages))
    sets: dict[str, Instances] = {name: {} for name in messages}
    for data in sorted(log.data_list, key=lambda data: data.multi_id):
        if len(data.data["timestamp"]):
            sets[data.name][data.multi_id] = data.data
    return sets, log.initial_parameters, DAMAGED if log.file_corruption else ""
