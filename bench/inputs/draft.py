"""A vehicle as far as a file of another project tells, and look-ups in parameter files."""

from dataclasses import dataclass, field
from typing import Any

from alloc.errors import VehicleError
from alloc.files.yaml_tree import YamlTree
from alloc.vehicle.frame import described
from alloc.vehicle.keys import Numbers
from bench.inputs.frames import of_comments


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
    limits_assumed : what of these the file does not say, one sentence each; void once both are told
    weights, slack_weights : (n,) and (k,) diagonals of H and Q
    frame : frd or flu
    frame_assumed : why that frame is taken, in a sentence; empty where the file, its format or the user says
    frame_refused : why no frame can be taken until the user says one; empty where one can
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
    frame: str = "frd"
    frame_assumed: str = ""
    frame_refused: str = ""
    limits_assumed: list[str] = field(default_factory=list)
    assumptions: list[str] = field(default_factory=list)


def with_comment(draft: Draft, text: str) -> Draft:
    """The draft in the frame that a comment of its file states; without one in its format's own, else frd."""
    stated = of_comments(text)
    if stated.frame:
        draft.frame, draft.frame_assumed = stated.frame, ""
    draft.frame_refused = stated.refusal
    if not (stated.frame or stated.refusal or draft.frame_assumed):
        draft.frame_assumed = f"The file names no frame: {described('frd')} is taken; --frame flu if z is up."
    return draft


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


def places(data: Any, name: str, within: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Below which keys one of that name stands, from outermost to innermost: an entry for each time."""
    if not isinstance(data, dict):
        return []
    inner = (places(value, name, (*within, str(key))) for key, value in data.items())
    return [*([within] if name in data else []), *(place for found in inner for place in found)]


def numbers(tree: YamlTree, key: str, value: Any) -> Numbers:
    """A flat list of numbers; raises VehicleError."""
    if not isinstance(value, list):
        raise VehicleError(f"{tree.path}: {key} is {_brief(value)}; give a list of numbers")
    for x in value:
        if not isinstance(x, (int, float)) or isinstance(x, bool):
            raise VehicleError(
                f"{tree.path}: {key} holds {_brief(x)}, which is no number; write it as 0.5 or -40"
            )
    return [float(x) for x in value]


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
            remedy = f"give {n} for each row" if n else "give 'thrusters: num:' to split it"
            raise VehicleError(f"{tree.path}: {key} has {len(flat)} numbers; {remedy}")
        matrix = [flat[i : i + n] for i in range(0, len(flat), n)]
    if len({len(row) for row in matrix}) != 1 or not matrix[0]:
        raise VehicleError(
            f"{tree.path}: rows of {key} differ in length or are empty; give one entry a thruster"
        )
    return matrix
