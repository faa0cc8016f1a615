"""File of ``thrustbench canary``: times of fixed work on one machine."""

from pathlib import Path

import msgspec

from alloc import AllocError


class CanaryError(AllocError):
    """A canary file, or a record's canaries, can't be used."""


class CanaryFile(msgspec.Struct):
    """One machine and its canaries.

    Attributes
    ----------
    canary_schema : 1, the only schema there is
    machine : what ``bench.harness.machine`` says of it (CPU, cores, memory, governor, OS, kernel)
    median_us : median time of each canary [us]
    """

    canary_schema: int
    machine: dict[str, str | int | float | bool | None]
    median_us: dict[str, float]


def read_canary(path: Path) -> CanaryFile:
    """Read a canary file; raises CanaryError."""
    remedy = "give a file that `thrustbench canary` wrote on the target"
    try:
        canaries = msgspec.json.decode(path.read_bytes(), type=CanaryFile)
    except OSError as error:
        raise CanaryError(f"{path}: can't be read ({error.strerror}); {remedy}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise CanaryError(f"{path}: {error}; {remedy}") from None
    if canaries.canary_schema != 1 or not canaries.median_us or min(canaries.median_us.values()) <= 0:
        raise CanaryError(f"{path}: holds no canary times of schema 1; {remedy}")
    return canaries
