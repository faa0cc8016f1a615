"""PX4 parameters ``CA_ROTOR*``: an airframe script, a QGroundControl ``.params`` file, or NAME VALUE lines.

Per rotor i: position PX, PY, PZ [m], axis AX, AY, AZ, thrust coefficient CT, moment ratio KM [m].
A thrust f gives the force axis f and the moment (position x axis - KM axis) f. Defaults are those of
PX4: axis (0, 0, -1), KM 0.05, x forward, y starboard, z down (docs.px4.io, parameter reference, Geometry).
Written is a ``.params`` file as QGroundControl loads it.
"""

import re
from math import isclose
from pathlib import Path

import numpy as np

from alloc import Vehicle
from alloc.errors import VehicleError
from alloc.files.px4 import AUTOMATIC, MOTORS_6DOF
from alloc.files.textfile import read_text
from alloc.vehicle import LARGEST
from alloc.vehicle.autopilot import PX4_FRAMES, px4_coefficients
from alloc.vehicle.file import poses, reaction_torques
from alloc.vehicle.frame import TURN
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import VehicleFile
from bench.inputs.draft import Draft, mismatch

_PARAMETER = re.compile(
    r"\b(CA_ROTOR(?:_COUNT|\d{1,2}_[A-Z]+)|CA_R_REV)[\s,=:\"]+((?:[^\s,\"#]+,)*)([^\s,\"#]+)"
)
"""Name, earlier values, value: pyulog's ulog_params writes all of a flight, commas between."""
_MOST = 32
AXES = {"PX": 0.0, "PY": 0.0, "PZ": 0.0, "AX": 0.0, "AY": 0.0, "AZ": -1.0, "KM": 0.05}
UNUSED = AXES | {"CT": 6.5}
"""Values of unused rotors in a file of all parameters, as floats of 32 bits."""
HELD = frozenset({"frame", "T", "planar", "thrusters", "center_of_mass", "reaction_torque", "f_min", "f_max"})
"""Keys of a vehicle file that the parameters hold, or are made of; PX4 always has all six axes."""
ROTORS = 12
"""Most rotors of PX4's module.yaml of its control allocator."""
FLOAT, INT = 9, 6
"""Types of parameters in a ``.params`` file."""
UNIT = 1e-3
"""Most by which a direction that T gives may miss the length of 1 [-]."""


def recognises(path: Path, text: str) -> bool:
    """True if the text sets rotor parameters."""
    return "CA_ROTOR" in text


def read(path: Path) -> Draft:
    """The Draft of a parameter file; raises VehicleError."""
    given, changed = _parameters(path)
    rotors = sorted({int(match[1]) for name in given if (match := re.match(r"CA_ROTOR(\d+)_", name))})
    count = int(given.get("CA_ROTOR_COUNT", len(rotors)))
    if not 0 < count <= _MOST:
        raise mismatch(path, "CA_ROTOR_COUNT", count, f"1 to {_MOST}")
    _check(path, given, rotors, count)
    table = np.array([[given.get(f"CA_ROTOR{i}_{key}", AXES[key]) for key in AXES] for i in range(count)])
    axes = table[:, 3:6]
    lengths = np.linalg.norm(axes, axis=1, keepdims=True)
    if (lengths == 0).any():
        raise mismatch(path, f"CA_ROTOR{int(np.argmin(lengths))}_AX, AY, AZ", "0, 0, 0", "an axis")
    axes = axes / lengths
    draft = Draft(source=f"{path.name}, PX4 parameters CA_ROTOR*", dof=DOF, frame="frd")
    draft.positions, draft.directions = table[:, :3].tolist(), axes.tolist()
    draft.reaction_torque = (0.0 - table[:, 6]).tolist()
    unset = sorted({key for key in AXES for i in range(count) if f"CA_ROTOR{i}_{key}" not in given})
    if unset:
        draft.assumptions.append(f"Where {', '.join(unset)} is not set, PX4's default is taken.")
    if changed:
        draft.assumptions.append(f"Of {', '.join(changed)}, changed in flight, the last value counts.")
    _limits(draft, given, count)
    return draft


def _check(path: Path, given: dict[str, float], rotors: list[int], count: int) -> None:
    """Raise VehicleError where rotors are left out or would be made up, or a thrust has the wrong sign."""
    if missing := [i for i in range(count) if i not in rotors]:
        name = f"CA_ROTOR{missing[0]}"
        raise VehicleError(
            f"{path}: nothing is set of {name}, one of {count} rotors; count them from 0 without a gap,"
            f" or set {name}_PX 0 if it stands at the origin"
        )
    for i in rotors:
        values = {key: given[name] for key in UNUSED if (name := f"CA_ROTOR{i}_{key}") in given}
        if i >= count and (
            said := [key for key, value in values.items() if not isclose(value, UNUSED[key], rel_tol=1e-6)]
        ):
            raise VehicleError(
                f"{path}: CA_ROTOR{i}_{said[0]} is set, but CA_ROTOR_COUNT is {count}; delete it, or raise"
                " the count"
            )
        if i < count and values.get("CT", 0.0) < 0:
            raise mismatch(
                path,
                f"CA_ROTOR{i}_CT",
                f"{values['CT']:g}",
                "above 0, along its axis",
                "turn AX, AY, AZ about",
            )


def _limits(draft: Draft, given: dict[str, float], count: int) -> None:
    coefficients = [given.get(f"CA_ROTOR{i}_CT") for i in range(count)]
    if any(c is None for c in coefficients):
        high = [1.0] * count
        draft.limits_assumed.append(
            "CT is not set for every rotor: limits are shares of full throttle, no newtons; multiply f_min"
            " and f_max by full thrust, or give --f-min and --f-max [N]."
        )
    else:
        high = [float(c or 0.0) for c in coefficients]
        draft.limits_assumed.append(
            "Full thrust of a rotor is its CT in N, as thrust = CT u^2 with u up to 1."
        )
    reversible = int(given.get("CA_R_REV", 0))
    low = [-high[i] if reversible >> i & 1 else 0.0 for i in range(count)]
    draft.set_limits(low, high, "Rotors push one way only unless CA_R_REV says otherwise.")


def _parameters(path: Path) -> tuple[dict[str, float], list[str]]:
    """Parameters by name, and the names of those with several values."""
    values: dict[str, float] = {}
    changed = []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        for name, earlier, text in _PARAMETER.findall(
            line.partition("#")[0]
        ):  # a comment may tell an older value
            try:
                values[name] = float(text)
            except ValueError:
                values[name] = np.nan
            if not abs(values[name]) <= LARGEST:
                expected = f"a number up to {LARGEST:g}"
                raise mismatch(path, f"line {number}: {name}", repr(text[:40]), expected)
            changed += [name] * bool(earlier)
    return values, changed


def write(keys: VehicleFile, vehicle: Vehicle) -> str:
    """The vehicle as PX4's parameters of geometry; raises VehicleError for a vehicle that they can't say.

    Positions are from the centre of mass, axes and positions in frd. CT is f_max in N, or in a unit of more
    that a comment names where that exceeds PX4's range. Every thruster with f_min below 0 is reversible.
    """
    _check_writable(keys, vehicle)
    mounting = poses(keys, vehicle.T)
    down = np.ones(3) if vehicle.frame == "frd" else TURN
    positions, axes = (mounting.positions - mounting.center) * down, mounting.directions * down
    coefficients, unit = px4_coefficients(vehicle.f_max)
    values = np.column_stack([positions, axes, coefficients, 0.0 - reaction_torques(keys, vehicle.n)])
    reversible = sum(1 << i for i, low in enumerate(vehicle.f_min.tolist()) if low < 0)
    lines = [
        f"# {keys.name}, written by thrustbench",
        f"# CT 1: {unit:g} N at full output, the same astern",
        *_unlike(vehicle),
        "# Vehicle-Id Component-Id Name Value Type",
        _line("CA_AIRFRAME", MOTORS_6DOF, INT),
        _line("CA_ROTOR_COUNT", vehicle.n, INT),
        _line("CA_R_REV", reversible, INT),
        *_choices(vehicle),
    ]
    for i, row in enumerate(values.tolist()):
        names = ("PX", "PY", "PZ", "AX", "AY", "AZ", "CT", "KM")
        lines += [
            _line(f"CA_ROTOR{i}_{key}", value + 0.0, FLOAT) for key, value in zip(names, row, strict=True)
        ]
    return "\n".join(lines) + "\n"


def _choices(vehicle: Vehicle) -> list[str]:
    """Lines of how PX4 shall allocate, where it is the vehicle's autopilot."""
    mixer = vehicle.autopilot
    if mixer is None or mixer.method != "px4":
        return []
    method = AUTOMATIC if mixer.frame == PX4_FRAMES["automatic"] else 0
    return [_line("CA_METHOD", method, INT), _line("MC_AIRMODE", mixer.airmode, INT)]


def _check_writable(keys: VehicleFile, vehicle: Vehicle) -> None:
    """Raise VehicleError for thrusters without a pose, too many of them, or such as push astern only."""
    mounting = poses(keys, vehicle.T)
    lengths = np.linalg.norm(mounting.directions, axis=1)
    odd = np.flatnonzero(~mounting.stands | (np.abs(lengths - 1.0) > UNIT))
    if odd.size:
        raise VehicleError(
            f"{keys.name}: T gives {vehicle.called(int(odd[0]))} no pose, which PX4's parameters need; write"
            " 'thrusters' with position and direction"
        )
    if vehicle.n > ROTORS:
        raise VehicleError(f"{keys.name}: {vehicle.n} thrusters; PX4 has parameters for {ROTORS}")
    if (still := np.flatnonzero(~(vehicle.f_max > 0))).size:
        raise VehicleError(
            f"{keys.name}: f_max of {vehicle.called(int(still[0]))} is"
            f" {vehicle.f_max[still[0]]:g}, expected above 0; turn its direction about"
        )


def _unlike(vehicle: Vehicle) -> list[str]:
    """A comment on thrusters whose thrust astern PX4 takes for another one."""
    low, high = vehicle.f_min, vehicle.f_max
    odd = np.flatnonzero((low < 0) & ~np.isclose(low, -high)).tolist()
    names = ", ".join(map(vehicle.called, odd))
    return [f"# f_min differs from -f_max, for which PX4 has no parameter: {names}"] if odd else []


def _line(name: str, value: float, kind: int) -> str:
    return f"1\t1\t{name}\t{value!r}\t{kind}"
