"""Vehicles in files of other projects. Each module here is one format, named after its file.

A module has ``recognises(path, text) -> bool`` and ``read(path) -> Draft``; where the format can be written
``write(keys, vehicle) -> str`` and ``HELD``, the keys of a vehicle file that it then holds; ``PATTERN`` where
``read`` also takes a pattern of thrusters' names.
"""

from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import msgspec

from alloc.errors import UnknownName
from alloc.files.modules import modules
from alloc.vehicle.frame import described
from alloc.vehicle.keys import Numbers, VehicleFile
from bench.inputs.frames import frame_in


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
    weights, slack_weights : (n,) and (k,) diagonals of H and Q
    frame : frd or flu
    frame_assumed : why that frame is taken, in a sentence; empty where the file or its format says it
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
    assumptions: list[str] = field(default_factory=list)


def commented(draft: Draft, text: str) -> Draft:
    """The draft in the frame that a comment of its file says, as this program writes it; else in frd."""
    if frame := frame_in(text):
        draft.frame = frame
    else:
        draft.frame_assumed = f"The file names no frame: {described('frd')} is taken; --frame flu if z is up."
    return draft


def formats() -> dict[str, ModuleType]:
    """Every format by name."""
    return modules(__name__)


def writable() -> tuple[str, ...]:
    """Names of the formats that can be written."""
    return tuple(name for name, module in formats().items() if hasattr(module, "write"))


def left_out(format_: str, keys: VehicleFile) -> list[str]:
    """The keys of a vehicle file that a format has no place for, where they say something."""
    said = [name for name, value in msgspec.to_builtins(keys).items() if value]
    if keys.thrusters and any(thruster.name for thruster in keys.thrusters):
        said.append("names")
    unheard = {"name", "source", "notes", *formats()[format_].HELD}
    return [name for name in dict.fromkeys(said) if name not in unheard]


def recognised(path: Path, text: str) -> ModuleType:
    """The format that recognises a file; raises UnknownName."""
    for module in formats().values():
        if module.recognises(path, text):
            return module
    raise UnknownName(
        f"{path}: none of the known formats ({', '.join(formats())}); it needs a .csv of T, or keys "
        "thruster_position, configuration_matrix, tam, CA_ROTOR parameters, <robot> or <sdf>"
    )
