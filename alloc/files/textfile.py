"""Text files, read whole within a bound and written whole or not at all; folders of them."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from alloc.errors import FileError

LARGEST = 200_000_000
"""Most bytes that are read: half a day of 6-DOF demands at 50 Hz. The bound also ends /dev/zero."""


def read_text(path: Path, largest: int = LARGEST) -> str:
    """The UTF-8 text of a file, without a byte order mark, line ends as they are; raises FileError."""
    try:
        with path.open("rb") as file:
            data = file.read(largest + 1)
    except (OSError, ValueError) as error:
        raise FileError(f"can't be read ({_reason(error)}); give a readable file", path=path) from None
    if len(data) > largest:
        raise FileError(f"is larger than {largest / 1e6:g} MB; give a smaller file", path=path)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise FileError("not UTF-8 text; give a text file saved as UTF-8", path=path, line=line) from None
    if "\0" in text:
        raise FileError("holds zero bytes; give a text file saved as UTF-8", path=path)
    return text


def write_text(path: Path, text: str) -> None:
    """Write a text as UTF-8, line ends as they are; raises FileError as ``write_bytes``."""
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError as error:  # half a letter, as in a name that was no UTF-8
        raise FileError(f"can't be written ({_reason(error)}); write names in UTF-8", path=path) from None
    write_bytes(path, data)


def write_bytes(path: Path, data: bytes, remedy: str = "name a place that can") -> None:
    """Write a file whole, or leave the old one as it was; raises FileError with the ``remedy``.

    The data go to a temporary file in the same folder, which takes the name once all of them are on the disk.
    """
    temporary = ""
    try:
        if path.exists() and not path.is_file():  # a pipe or /dev/stdout can't be replaced
            path.write_bytes(data)
            return
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except (OSError, ValueError) as error:
        if temporary:
            Path(temporary).unlink(missing_ok=True)
        raise FileError(f"can't be written ({_reason(error)}); {remedy}", path=path) from None


def write_folder(folder: Path, files: Mapping[str, str]) -> None:
    """Write texts by their names into a folder, made if missing; raises FileError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise FileError(f"can't be written ({_reason(error)}); give another --out", path=folder) from None


def _reason(error: OSError | ValueError) -> str:
    return str(getattr(error, "strerror", None) or error).lower()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
