"""The errors of this library. Every message names the culprit and the remedy in one line."""


class AllocError(Exception):
    """Base of all errors this library raises on purpose."""


class VehicleError(AllocError):
    """A vehicle's data contradict themselves or miss something.

    Attributes
    ----------
    key : key of the vehicle file that is to be mended; empty where no single key is
    """

    def __init__(self, message: str, key: str = "") -> None:
        super().__init__(message)
        self.key = key


class DemandError(AllocError, ValueError):
    """A demand has the wrong shape, or an entry that is no real number or larger than LARGEST_DEMAND."""


class FileError(AllocError):
    """A file can't be read or written, or is not the kind of file that was asked for."""


class UnknownName(AllocError, LookupError):
    """No method, solver, vehicle or option has that name."""


class NotInstalled(AllocError):
    """A method is known here, but a package or tool that it needs is missing."""


class NotApplicable(AllocError):
    """A method does not cover this vehicle; the message says which premise fails."""


class SolverError(AllocError):
    """A solver failed in a way, or with a status, that this library does not know."""
