"""Report of a check of a vehicle file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from alloc.lint.failures import Failure

Level = Literal["error", "warning", "note"]
"""An error makes the file unusable, a warning deserves a second look, a note states an assumption or a
consequence."""
Remark = tuple[Level, str, str]
"""Level, key of the file that the remark is about (empty where there is none), and message."""
FARTHEST_ARM = 100.0  # m; a longer arm is probably written in mm


def error(key: str, message: str) -> Remark:
    """A remark that the file can't be used as it is."""
    return "error", key, message


def warning(key: str, message: str) -> Remark:
    """A remark on what deserves a second look."""
    return "warning", key, message


def note(key: str, message: str) -> Remark:
    """A remark on an assumption or a consequence."""
    return "note", key, message


class Finding(NamedTuple):
    """One remark on a vehicle file, with its place.

    Attributes
    ----------
    level : how bad it is
    key : key of the file that the remark is about; empty where there is none
    line : line of that key; None where the file does not hold it
    message : what is the matter, and what to do about it
    """

    level: Level
    key: str
    line: int | None
    message: str


class Facts(NamedTuple):
    """Facts that follow from a usable file.

    Attributes
    ----------
    name : name of the vehicle
    k : number of controlled degrees of freedom
    n : number of thrusters
    rank : rank of T
    nullity : thrusters less rank
    condition : condition number of T with rows of unit length [-]
    worst_case_steps : steps of the exact method at worst; None where that does not apply
    frame : frd or flu, of everything about the vehicle
    """

    name: str
    k: int
    n: int
    rank: int
    nullity: int
    condition: float
    worst_case_steps: int | None
    frame: str = "frd"


@dataclass(frozen=True)
class Report:
    """All findings about one file.

    Attributes
    ----------
    path : the file
    facts : what follows from it; None where T, H or the limits are unusable
    findings : the remarks, errors first
    failures : what each loss of one thruster costs
    """

    path: Path
    facts: Facts | None
    findings: tuple[Finding, ...]
    failures: tuple[Failure, ...] = ()

    def count(self, level: Level) -> int:
        """How many findings have that level."""
        return sum(finding.level == level for finding in self.findings)
