"""Vehicles in other people's files. One file one format, found by its name.

A module reads with ``recognises(path, text) -> bool`` and ``read(path) -> Draft``; one that also
writes has ``write(keys, vehicle) -> str``.
"""

import pkgutil
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from types import ModuleType

from alloc import UnknownName
from alloc.vehicle.file import Numbers


@dataclass
class Draft:
    """A vehicle as far as a foreign file tells, in its own frame; None or empty where it does not.

    Attributes
    ----------
    source : what file, in words
    dof : names of the rows of T, or of the axes that are controlled; empty where nothing says
    T : (k, n) rows
    positions, directions : (n, 3) poses [m], [-]
    center_of_mass : (3,) [m]
    f_min, f_max : one limit or one a thruster [N]
    weights, slack_weights : diagonals of H and Q
    frame : frd or flu
    assumptions : what the file does not say and was taken for granted, one sentence each
    """

    source: str
    dof: tuple[str, ...] = ()
    T: list[Numbers] | None = None
    positions: list[Numbers] | None = None
    directions: list[Numbers] | None = None
    center_of_mass: Numbers | None = None
    f_min: float | Numbers | None = None
    f_max: float | Numbers | None = None
    weights: Numbers | None = None
    slack_weights: Numbers | None = None
    frame: str = "frd"
    assumptions: list[str] = field(default_factory=list)


def formats() -> dict[str, ModuleType]:
    """Every format by name."""
    names = [found.name for found in pkgutil.iter_modules(__path__)]
    return {name: import_module(f"bench.inputs.formats.{name}") for name in names}


def writable() -> tuple[str, ...]:
    """Names of the formats that can be written."""
    return tuple(name for name, module in formats().items() if hasattr(module, "write"))


def recognised(path: Path, text: str) -> ModuleType:
    """The format of a file, told by its content; raises UnknownName."""
    for module in formats().values():
        if module.recognises(path, text):
            return module
    raise UnknownName(
        f"{path}: none of the known formats ({', '.join(formats())}); it needs a .csv of T, or keys "
        "thruster_position, configuration_matrix, tam, or CA_ROTOR parameters"
    )
