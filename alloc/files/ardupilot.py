"""ArduSub's parameters: a ground station's text, and the frame, directions and coupling in it."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from alloc.errors import FileError
from alloc.files.textfile import read_text

_LINE = re.compile(r"(?:\d+\s+\d+\s+)?([A-Z][A-Z0-9_]*)[\s,=]+(-?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)\b")
"""NAME,VALUE or NAME VALUE, and QGroundControl's columns: vehicle, component, name, value, type."""
DIRECTION = re.compile(r"MOT_(\d+)_DIRECTION")
SETTING = "FRAME_CONFIG"


class Settings(NamedTuple):
    """ArduSub's own parameters.

    Attributes
    ----------
    frame : FRAME_CONFIG, an index
    reverse : motors whose MOT_n_DIRECTION is -1, from 1
    coupling : MOT_FV_CPLNG_K [-]
    """

    frame: int
    reverse: tuple[int, ...]
    coupling: float


def read_parameters(path: Path) -> dict[str, float]:
    """All parameters of a file, by name; raises FileError where it is none of a ground station's."""
    lines = [line.split("#")[0].strip() for line in read_text(path).splitlines()]
    matches = [match for line in lines if (match := _LINE.match(line))]
    if not matches:
        raise FileError(f"holds no parameters; expected lines {SETTING},2", path=path)
    return {match[1]: float(match[2]) for match in matches}


def sub_settings(given: Mapping[str, float], path: Path) -> Settings:
    """Settings of ArduSub's mixer; raises FileError where the parameters are not ArduSub's."""
    if SETTING not in given:
        copter = [name for name in ("FRAME_CLASS", "Q_FRAME_CLASS") if name in given]
        whose = f"it has {copter[0]}, so it is no ArduSub's" if copter else f"of {len(given)} parameters none"
        raise FileError(f"no {SETTING}: {whose}; give the file of an ArduSub", path=path)
    ways = {int(match[1]): value for name, value in given.items() if (match := DIRECTION.fullmatch(name))}
    reverse = tuple(sorted(motor for motor, value in ways.items() if value < 0))
    return Settings(int(given[SETTING]), reverse, given.get("MOT_FV_CPLNG_K", 1.0))
