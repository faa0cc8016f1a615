"""PX4's parameters of its control allocator: how it allocates, and for how many rotors."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from alloc.errors import FileError

OURS = ("CA_AIRFRAME", "CA_METHOD", "MC_AIRMODE", "MC_AIRMODE_LIM", "CA_ROTOR_COUNT")
"""Parameters by which a file is known as PX4's."""
MOTORS_6DOF = 7
"""CA_AIRFRAME of a vehicle whose motors make all six forces and moments."""
AUTOMATIC = 2
"""CA_METHOD that leaves the choice to the airframe."""
METHODS = {0: "pseudoinverse", 1: "automatic", AUTOMATIC: "automatic"}
"""Allocation by CA_METHOD of such a vehicle: 1 and 2 are the same sequential desaturation."""


class Px4Settings(NamedTuple):
    """PX4's own parameters.

    Attributes
    ----------
    method : one of METHODS
    airmode : MC_AIRMODE, 0 where the file does not say
    rotors : CA_ROTOR_COUNT, 0 where the file does not say
    """

    method: str
    airmode: int
    rotors: int


def is_px4(given: Mapping[str, float]) -> bool:
    """True if parameters by name are PX4's."""
    return any(name in given for name in OURS)


def px4_settings(given: Mapping[str, float], path: Path) -> Px4Settings:
    """Settings of PX4's allocation; raises FileError for another airframe's, and for another airmode."""
    if (airframe := given.get("CA_AIRFRAME", MOTORS_6DOF)) != MOTORS_6DOF:
        raise FileError(
            f"CA_AIRFRAME is {airframe:g}, expected {MOTORS_6DOF}: motors that make all six axes", path=path
        )
    if (method := given.get("CA_METHOD", AUTOMATIC)) not in METHODS:
        raise FileError(f"CA_METHOD is {method:g}; give 0, 1 or 2", path=path)
    if (limit := given.get("MC_AIRMODE_LIM", 0.0)) != 0.0:
        raise FileError(
            f"MC_AIRMODE_LIM is {limit:g}, of PX4 after v1.17; leave it out, and give MC_AIRMODE 0, 1 or 2",
            path=path,
        )
    if (airmode := given.get("MC_AIRMODE", 0)) not in (0, 1, 2):
        raise FileError(f"MC_AIRMODE is {airmode:g}; give 0, 1 or 2", path=path)
    plain = METHODS[int(method)] == "pseudoinverse"  # which reads no airmode
    return Px4Settings(
        METHODS[int(method)], 0 if plain else int(airmode), int(given.get("CA_ROTOR_COUNT", 0))
    )
