"""Keys of a vehicle file written as YAML that is easy to read and reads back the same."""

import json
import re
from typing import Any

import msgspec

from alloc.vehicle.keys import VehicleFile

_PLAIN = re.compile(r"[A-Za-z][\w.,/@()+-]*( [\w.,/@()+-]+)*")
_WORDS = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"}  # no text in some version of YAML


def to_yaml(keys: VehicleFile) -> str:
    """The text of a vehicle file: one key a line, one thruster or row of a matrix a line."""
    lines = []
    for key, value in msgspec.to_builtins(keys).items():
        if (
            isinstance(value, (list, tuple))
            and value
            and isinstance(value[0], (list, dict, str))
            and key != "dof"
        ):
            lines.append(f"{key}:")
            lines += [f"  - {_flow(entry)}" for entry in value]
        else:
            lines.append(f"{key}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, str):
        plain = _PLAIN.fullmatch(value) and value.lower() not in _WORDS
        return value if plain else json.dumps(value, ensure_ascii=False)
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return repr(value)
