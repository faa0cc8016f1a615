"""What can go wrong, as types. Every message names the culprit and the remedy in one line."""


class AllocError(Exception):
    """Base of all errors this library raises on purpose."""


class VehicleError(AllocError):
    """A vehicle's data contradict themselves or miss something; ``key`` is the culprit where there is one."""

    def __init__(self, message: str, key: str = "") -> None:
        super().__init__(message)
        self.key = key


class DemandError(AllocError, ValueError):
    """A demand has the wrong shape, is no number, or is larger than any wrench."""


class FileError(AllocError):
    """A file can't be read or written, or is not the kind of file that was asked for."""


class UnknownName(AllocError, LookupError):
    """No method, solver, vehicle or option has that name."""


class NotInstalled(AllocError):
    """A method is known here, but a package or tool that it needs is missing."""


class NotApplicable(AllocError):
    """A method does not cover this vehicle; the message says which premise fails."""


class SolverError(AllocError):
    """A solver answered in a way that nobody mapped."""
