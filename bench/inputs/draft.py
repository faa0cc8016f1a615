"""A vehicle as far as a file of another project tells, and look-ups in parameter files."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from alloc.errors import VehicleError
from alloc.files.yaml_tree import YamlTree
from alloc.vehicle.keys import Numbers


@dataclass(kw_only=True)
class Draft:
    """A vehicle as far as a file tells, in the file's own frame; None or empty where the file does not tell.

    Attributes
    ----------
    source : name and kind of the file, in words
    dof : names of the rows of T, or without T of the controlled axes
    T : (k, n) rows [-], [m]
    positions, directions : (n, 3) poses [m], [-]
    center_of_mass : (3,) [m]
    reaction_torque : (n,) each propeller's own moment along its thrust [m]
    names : (n,) what the thrusters are called
    f_min, f_max : one limit for all thrusters, or one each [N]
    limits_assumed : what of these the file does not say, one sentence each; void once the user gives both
    weights, slack_weights : (n,) and (k,) diagonals of H and Q
    frame : frd or flu; empty where neither the file's keys nor its format say one
    frame_assumed : why that frame is taken, in a sentence, unless a comment or the user says one; empty where
        the file or its format does
    assumptions : what else the file does not say and is assumed, one sentence each
    """

    source: str
    dof: tuple[str, ...] = ()
    T: list[Numbers] | None = None
    positions: list[Numbers] | None = None
    directions: list[Numbers] | None = None
    center_of_mass: Numbers | None = None
    reaction_torque: Numbers | None = None
    names: list[str] | None = None
    f_min: float | Numbers | None = None
    f_max: float | Numbers | None = None
    weights: Numbers | None = None
    slack_weights: Numbers | None = None
    frame: str = ""
    frame_assumed: str = ""
    limits_assumed: list[str] = field(default_factory=list)
    assumptions: list[str] = field(default_factory=list)

    def set_limits(self, low: Sequence[float | None], high: Sequence[float | None], *assumed: str) -> None:
        """Take limits (n,) [N] that all thrusters have, as one number where they are alike.

        The sentences of ``assumed`` hold where both sides are taken.
        """
        sides = [[end for end in side if end is not None] for side in (low, high)]
        taken = [side if len(side) == len(low) else [] for side in sides]
        self.f_min, self.f_max = (None if not s else s[0] if len({*s}) == 1 else s for s in taken)
        self.limits_assumed += assumed if all(taken) else ()


def mismatch(source: YamlTree | Path, key: str, got: object, expected: str, remedy: str = "") -> VehicleError:
    """The error of a key, for its reader to raise: ``file, line: key: got X, expected Y; remedy``."""
    path, line = (source, None) if isinstance(source, Path) else (source.path, source.line(key))
    where = f"{path}, line {line}" if line else str(path)
    return VehicleError(f"{where}: {key}: got {got}, expected {expected}{remedy and '; '}{remedy}")


def has_key(text: str, *names: str) -> bool:
    """True if a line of YAML begins with one of these keys."""
    return any(line.strip().startswith(tuple(f"{name}:" for name in names)) for line in text.splitlines())


def find(tree: YamlTree, *names: str) -> Any:
    """The value of the first key with one of these names, outermost and topmost first; None without one."""
    level = [tree.data]
    while level:
        maps = [data for data in level if isinstance(data, dict)]
        for data in maps:
            for name in names:
                if name in data:
                    return data[name]
        level = [value for data in maps for value in data.values()]
    return None


def numbers(tree: YamlTree, key: str, value: Any) -> Numbers:
    """A flat list of numbers; raises VehicleError."""
    if not isinstance(value, list):
        raise mismatch(tree, key, _brief(value), "a list of numbers")
    for x in value:
        if not isinstance(x, (int, float)) or isinstance(x, bool):
            raise mismatch(tree, key, _brief(x), "a number such as 0.5 or -40")
    return [float(x) for x in value]


def ends(tree: YamlTree, nodes: Sequence[Any], key: str, what: str) -> list[float | None]:
    """The number under a key of each table; None where there is none. Raises VehicleError."""
    return [
        numbers(tree, what, [node[key]])[0] if isinstance(node, dict) and key in node else None
        for node in nodes
    ]


def _brief(value: Any) -> str:
    """The value in a few words."""
    kinds = {dict: "a table of keys", list: "a list", type(None): "empty"}
    return kinds.get(type(value), repr(str(value))[:42])


def rows(tree: YamlTree, key: str, value: Any, n: int | None = None) -> list[Numbers]:
    """A matrix given as rows, or flat with n columns; raises VehicleError."""
    if isinstance(value, list) and value and all(isinstance(row, list) for row in value):
        matrix = [numbers(tree, key, row) for row in value]
    else:
        flat = numbers(tree, key, value)
        if not n or not flat or len(flat) % n:
            expected = f"{n} for each row" if n else "rows, or 'thrusters: num:' to split it"
            raise mismatch(tree, key, f"{len(flat)} numbers", expected)
        matrix = [flat[i : i + n] for i in range(0, len(flat), n)]
    if len({len(row) for row in matrix}) != 1 or not matrix[0]:
        raise VehicleError(
            f"{tree.path}: rows of {key} differ in length or are empty; give one entry a thruster"
        )
    return matrix
