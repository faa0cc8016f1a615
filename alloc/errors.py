"""The errors of this library. Every message names the culprit and the remedy in one line."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


class AllocError(Exception):
    """Base of all errors this library raises on purpose."""


class _InFile(AllocError):
    """An error that may stand somewhere in a file; its message begins with that place.

    Attributes
    ----------
    what : the message without the place
    path, line : the place, None where it is not known
    """

    def __init__(self, what: str, *, path: Path | None = None, line: int | None = None) -> None:
        place = "" if path is None else f"{path}, line {line}: " if line else f"{path}: "
        super().__init__(place + what)
        self.what, self.path, self.line = what, path, line


class VehicleError(_InFile):
    """A vehicle's data contradict themselves or miss something.

    Attributes
    ----------
    what, path, line : the message and its place
    key : key of the vehicle file that is to be mended; empty where no single key is
    """

    def __init__(
        self, what: str, key: str = "", *, path: Path | None = None, line: int | None = None
    ) -> None:
        super().__init__(what, path=path, line=line)
        self.key = key


class DemandError(AllocError, ValueError):
    """A demand has the wrong shape, or an entry that is no real number or larger than LARGEST_DEMAND."""


class FileError(_InFile):
    """A file can't be read or written, or is not the kind of file that was asked for."""


class UnknownName(AllocError, LookupError):
    """No method, solver, vehicle or option has that name."""


def unknown(kind: str, name: str, known: Iterable[str], remedy: str = "") -> UnknownName:
    """The error for a name that is none of the known ones: the names close to it, else all of them."""
    names = list(known)
    close = get_close_matches(name, names, n=3)
    hint = f"did you mean {' or '.join(close)}?" if close else f"there are {', '.join(names)}"
    return UnknownName(f"no {kind} {name[:60]!r}; {hint}{remedy}")


class NotInstalled(AllocError):
    """A method is known here, but a package or tool that it needs is missing."""


class NotApplicable(AllocError):
    """A method does not cover this vehicle; the message says which premise fails."""


class PluginError(AllocError):
    """A plug-in is not what it must be; the message says what it must return or declare."""


class SolverError(AllocError):
    """A solver failed in a way, or with a status, that this library does not know."""
