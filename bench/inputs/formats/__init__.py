"""Vehicles in files of other projects. Each module here is one format, named after its file.

A module of a format that can be read has ``recognises(path, text) -> bool`` and ``read(path) -> Draft``, and
``PATTERN`` where ``read`` also takes a pattern of thrusters' names; of one that can be written,
``write(keys, vehicle) -> str`` and ``HELD``, the keys of a vehicle file that it then holds.
"""

from pathlib import Path
from types import ModuleType

import msgspec

from alloc.errors import UnknownName
from alloc.files.modules import modules
from alloc.vehicle.keys import VehicleFile


def formats() -> dict[str, ModuleType]:
    """Every format by name."""
    return modules(__name__)


def readable() -> dict[str, ModuleType]:
    """Every format that can be read, by name."""
    return {name: module for name, module in formats().items() if hasattr(module, "read")}


def writable() -> tuple[str, ...]:
    """Names of the formats that can be written."""
    return tuple(name for name, module in formats().items() if hasattr(module, "write"))


def lost_keys(format_: str, keys: VehicleFile) -> list[str]:
    """The keys of a vehicle file that a format has no place for, where they say something."""
    said = [name for name, value in msgspec.to_builtins(keys).items() if value]
    if keys.thrusters and any(thruster.name for thruster in keys.thrusters):
        said.append("names")
    unheard = {"name", "source", "notes", *formats()[format_].HELD}
    return [name for name in dict.fromkeys(said) if name not in unheard]


def find_format(path: Path, text: str) -> ModuleType:
    """The format that recognises a file; raises UnknownName."""
    for module in readable().values():
        if module.recognises(path, text):
            return module
    raise UnknownName(
        f"{path}: none of the known formats ({', '.join(readable())}); it needs a .csv of T, or keys "
        "thruster_position, configuration_matrix, control_allocation_matrix, tam, CA_ROTOR parameters, "
        "<robot> or <sdf>, or thrusters that each have a position and a direction"
    )
