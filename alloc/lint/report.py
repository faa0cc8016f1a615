"""Report of a check of a vehicle file: its findings, and the report as a table or JSON."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal, NamedTuple, get_args

from alloc.lint.probe import Probe
from alloc.vehicle.frame import described

Level = Literal["error", "warning", "note"]
"""An error makes the file unusable, a warning deserves a second look, a note states an assumption or a
consequence."""
Remark = tuple[Level, str, str]
"""Level, key of the file that the remark is about (empty where there is none), and message."""
LITTLE = 0.995
"""Share of an axis's range from which a failure counts as costing nothing there."""
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


class Failure(NamedTuple):
    """A vehicle without one of its thrusters.

    Attributes
    ----------
    thruster : its index
    name : what people call it, empty where it has no name
    last : whether no thruster is left
    lost : the directions that nothing pushes any more, each by the axes that it couples
    condition : of T P over the rank that is left; see ``condition``
    left : of each axis, the share of its range that is left where only this axis is pushed
    weak : the largest sigma / sigma_max of the directions that are weak, not lost to the last digit [-]
    in_part : of each direction that the failure makes count in part, by its axes, the share to which it does
    """

    thruster: int
    name: str
    last: bool = False
    lost: tuple[tuple[str, ...], ...] = ()
    condition: float | None = None
    left: Mapping[str, float] = MappingProxyType({})
    weak: float = 0.0
    in_part: Mapping[str, float] = MappingProxyType({})

    @property
    def words(self) -> str:
        """Cost of the failure in words: ``no pitch``, ``no heave and roll together``, ``surge 50 %``."""
        if self.last:
            return "no thruster is left"
        if self.lost:
            said = _none_of(self.lost)
            named = {axis for axes in self.lost for axis in axes}
            # A small coefficient names no axis, and still ties it to those that are lost.
            said += [
                f"no {axis} alone" for axis, share in self.left.items() if not share and axis not in named
            ]
            return ", ".join([*said, *_counting(self.in_part)]) + _though(self.weak)
        axes = [f"{axis} {100 * share:.0f} %" for axis, share in self.left.items() if share < LITTLE]
        kept = f"{', '.join(axes)} of the range left" if axes else "every axis keeps its full range"
        return ", ".join([*_counting(self.in_part), kept])


def together(axes: Sequence[str]) -> str:
    """``pitch``, ``heave, roll and pitch together``."""
    return axes[0] if len(axes) == 1 else f"{', '.join(axes[:-1])} and {axes[-1]} together"


def _none_of(lost: Sequence[Sequence[str]]) -> list[str]:
    return [f"no {together(axes)}" for axes in lost]


def _counting(in_part: Mapping[str, float]) -> list[str]:
    return [f"{axes} counted by {percent(counts)} %" for axes, counts in in_part.items()]


def percent(share: float) -> str:
    """A share in per cent with one digit, or as many as stand before the point."""
    return f"{100 * share:.1g}" if share < 0.095 else f"{100 * share:.0f}"


def _though(weak: float) -> str:
    return f" (the file promises {percent(weak)} %, the survey does not)" if weak else ""


class Pairs(NamedTuple):
    """Pairs of thrusters whose loss takes the same directions.

    Attributes
    ----------
    names : what the two of each pair are called
    lost : the directions that nothing pushes any more, or weakly, each by the axes that it couples
    weak, in_part : as of ``Failure``, the least share of these pairs
    """

    names: tuple[tuple[str, str], ...]
    lost: tuple[tuple[str, ...], ...]
    weak: float = 0.0
    in_part: Mapping[str, float] = MappingProxyType({})

    @property
    def words(self) -> str:
        """``4 + 5, 6 + 7: no heave and pitch together``."""
        named = ", ".join(" + ".join(name.removeprefix("thruster ") for name in pair) for pair in self.names)
        costs = [*_none_of(self.lost), *_counting(self.in_part)]
        return f"{named}: {', '.join(costs)}{_though(self.weak)}"


@dataclass(frozen=True)
class Report:
    """All findings about one file.

    Attributes
    ----------
    path : the file
    facts : what follows from it; None where T, H or the limits are unusable
    findings : the remarks, errors first
    failures : what each loss of one thruster costs
    pairs : which losses of two take directions
    """

    path: Path
    facts: Facts | None
    findings: tuple[Finding, ...]
    failures: tuple[Failure, ...] = ()
    pairs: tuple[Pairs, ...] = ()

    def count(self, level: Level) -> int:
        """Number of findings of that level."""
        return sum(finding.level == level for finding in self.findings)


def to_json(report: Report, tried: Sequence[Probe] | None = None) -> str:
    """One JSON object: file, usable, facts or null, findings, failures; probe where there is one."""
    probe = {} if tried is None else {"probe": [one._asdict() for one in tried]}
    return json.dumps(
        {
            "file": str(report.path),
            "usable": report.count("error") == 0,
            "facts": None if report.facts is None else report.facts._asdict(),
            "findings": [finding._asdict() for finding in report.findings],
            "failures": [failure._asdict() for failure in report.failures],
            "pairs": [pair._asdict() for pair in report.pairs],
        }
        | probe,
        indent=2,
        ensure_ascii=False,
    )


def as_table(report: Report) -> str:
    """One line of facts, one line for each finding, and the number of findings by level."""
    lines = []
    if facts := report.facts:
        steps = (
            "" if facts.worst_case_steps is None else f", exact method at most {facts.worst_case_steps} steps"
        )
        lines.append(
            f"{facts.name}: {facts.k} DOF, {facts.n} thrusters, rank {facts.rank}, "
            f"d = {facts.nullity}, condition {facts.condition:.3g}{steps}, frame {described(facts.frame)}"
        )
    for level, key, line, message in report.findings:
        place = f"line {line}, " if line else ""
        named = f"{key}: {message.removeprefix(f'{key}: ')}" if key else message
        lines.append(f"{level:7}  {place}{named}")
    lines += [f"two off  {pair.words}" for pair in report.pairs]
    counts = [(report.count(level), level) for level in get_args(Level)]
    total = ", ".join(f"{count} {level}{'' if count == 1 else 's'}" for count, level in counts)
    return "\n".join([*lines, f"{report.path}: {total}"])
