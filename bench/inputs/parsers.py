"""Other projects' parsers of logs: what they raise at damaged bytes; PX4's, for two kinds of log."""

from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path
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
        said = " ".join(f"{type(error).__name__}: {error}".split())[:80]
        raise FileError(f"{path}: not a {what} that {library} can read ({said})") from None


def read_ulog(path: Path, *messages: str) -> tuple[dict[str, dict[str, Any]], dict[str, Any]]:
    """The first instance of each message in a ULog, by name, and the parameters at its beginning.

    Raises NotInstalled without pyulog, and within ``parsing`` FileError for what is no ULog.
    """
    try:
        from pyulog.core import ULog
    except ImportError:
        raise NotInstalled("reading ULogs needs pyulog; pip install 'thrustbench[px4]'") from None
    # pyulog prints warnings of damaged parts, but standard output is for results; gaps show the damage.
    with path.open("rb") as file, redirect_stdout(StringIO()):
        log = ULog(file, list(messages))
    return {data.name: data.data for data in log.data_list if data.multi_id == 0}, log.initial_parameters
