"""A list of thrusters, or a table of them by name, each with a position and a direction, in YAML.

Teams write such files under keys of their own: ``pos`` and ``rpy`` in degrees (config/oogway.yaml of
DukeRobotics/robosub-ros @0f782a0, whose thrust is along x of the rotated frame), ``position`` and
``direction`` with ``thrust_bounds`` [N] (thruster_layout.yaml of uf-mil/mil). What such a file leaves open,
the order of a quaternion or the unit of angles, is refused where its numbers do not tell.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from alloc.errors import VehicleError
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import Numbers
from bench.inputs.columns import listed
from bench.inputs.description import SHORTEST, exact_angle
from bench.inputs.draft import Draft, mismatch, numbers

UNITS = {"": 1.0, "_m": 1.0, "_cm": 1e-2, "_mm": 1e-3}
POSITIONS = {f"{name}{unit}": size for name in ("position", "pos", "xyz") for unit, size in UNITS.items()}
"""Keys of positions, and their units in m."""
AXES = ("direction", "axis", "force_direction", "thrust_direction")
ANGLES = ("rpy", "rpy_deg", "rpy_rad")
QUATERNIONS = {
    f"{name}{order}": order[1:] for name in ("quaternion", "quat") for order in ("", "_xyzw", "_wxyz")
}
"""Keys of quaternions, and the order of their numbers; empty where the key does not say it."""
ROTATIONS = ("roll", "pitch", "yaw")
DIRECTIONS = (*AXES, *ANGLES, *QUATERNIONS, "orientation")
TURNED = ("flipped", "inverted", "reversed", "invert", "reverse")
"""Flags that turn an axis in one program, and a driver's command in another."""
NAMES, NESTED = ("name", "id"), ("pose", "origin")
"""Keys of what a thruster is called, and of a table that holds its position and its direction."""
FARTHEST = 20.0
"""Coordinate from which a position is none in metres, of a vehicle that does not say its unit [m]."""


def recognises(path: Path, text: str) -> bool:
    """True if the file is YAML with a group of such entries, and no vehicle file itself."""
    if path.suffix.lower() not in (".yaml", ".yml") or not any(key in text for key in POSITIONS):
        return False
    tree = read_yaml(path)
    return not (isinstance(tree.data, dict) and "dof" in tree.data) and bool(list(_groups(tree.data, "")))


def read(path: Path) -> Draft:
    """The Draft of such a file; raises FileError or VehicleError."""
    tree = read_yaml(path)
    place, entries = _thrusters(tree)
    keys = {_only(tree, where, entry, POSITIONS, "position") for where, (_, entry) in entries.items()}
    ways = {_only(tree, where, entry, DIRECTIONS, "direction") for where, (_, entry) in entries.items()}
    if len(keys) > 1 or len(ways) > 1:
        both = listed(sorted(keys if len(keys) > 1 else ways))
        raise VehicleError(f"{path}: entries of {place} have {both}; give every thruster the same keys")
    (key,), (way,) = keys, ways
    for where, (_, entry) in entries.items():
        if turned := [flag for flag in TURNED if entry.get(flag)]:
            remedy = f"give the direction in which positive thrust pushes, and leave {turned[0]} out"
            raise mismatch(tree, where, f"{turned[0]}, of its axis or its driver's command", "none", remedy)
    draft = Draft(source=f"{path.name}, positions and directions of {place}", dof=DOF)
    draft.positions = [
        [POSITIONS[key] * x for x in _vector(tree, f"{where}.{key}", entry[key], "xyz")]
        for where, (_, entry) in entries.items()
    ]
    if (farthest := np.abs(draft.positions).max()) > FARTHEST:
        raise mismatch(path, key, f"up to {farthest:g}", "m", f"if that is mm, call it {key}_mm")
    given = {f"{where}.{way}": entry[way] for where, (_, entry) in entries.items()}
    draft.directions, meaning = _directions(tree, way, given)
    names = [name for name, _ in entries.values()]
    draft.names = names if any(names) else None
    draft.assumptions += [
        f"Positions are in {'m' if POSITIONS[key] == 1 else key.rpartition('_')[2]}, from the point about"
        " which moments are taken.",
        meaning,
    ]
    bounds = [entry.get("thrust_bounds") for _, entry in entries.values()]
    if all(bound is not None for bound in bounds):
        ends = [numbers(tree, "thrust_bounds", bound) for bound in bounds]
        if any(len(pair) != 2 for pair in ends):
            raise mismatch(path, "thrust_bounds", "no pair", "the least and the largest thrust [N]")
        low, high = zip(*ends, strict=True)
        draft.set_limits(low, high, "Limits are thrust_bounds, in N.")
    others = sorted(
        {k for _, entry in entries.values() for k in entry} - {key, way, *NAMES, *NESTED, "thrust_bounds"}
    )
    if others:
        draft.assumptions.append(f"Left out of each thruster: {listed(others)}.")
    return draft


def _groups(data: Any, where: str) -> Iterator[tuple[str, dict[str, tuple[str, dict[str, Any]]]]]:
    """Lists and tables of which some entry has a position and a direction: entries by place, with names."""
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    entries = {}
    for name, value in inner:
        here = f"{where}[{name}]" if isinstance(data, list) else f"{where}.{name}" if where else str(name)
        if isinstance(value, dict) and name not in NESTED:
            nested: dict[str, Any] = next((value[k] for k in NESTED if isinstance(value.get(k), dict)), {})
            called = next((value[k] for k in NAMES if k in value), "" if isinstance(data, list) else name)
            entries[here] = (str(called)[:40], value | nested)
        yield from _groups(value, here)
    if any(set(e) & set(POSITIONS) and set(e) & set(DIRECTIONS) for _, e in entries.values()):
        yield where or "the file", entries


def _thrusters(tree: YamlTree) -> tuple[str, dict[str, tuple[str, dict[str, Any]]]]:
    """The group of thrusters: the only one, or the only one that is called so; raises VehicleError."""
    groups = dict(_groups(tree.data, ""))
    named = [place for place in groups if any(w in place.lower() for w in ("thruster", "motor", "propeller"))]
    chosen = named or list(groups)
    if len(chosen) != 1:
        if not chosen:
            raise VehicleError(f"{tree.path}: no list of thrusters; give each a position and a direction")
        raise VehicleError(
            f"{tree.path}: {listed(chosen)} have positions and directions; keep the thrusters'"
        )
    return chosen[0], groups[chosen[0]]


def _only(tree: YamlTree, where: str, entry: Mapping[str, Any], keys: Collection[str], what: str) -> str:
    """The one of some keys that an entry has; raises VehicleError for none, or two."""
    found = [key for key in keys if key in entry]
    if len(found) != 1:
        got = listed(found) if found else f"no {what}"
        raise mismatch(tree, where, got, f"one of {listed(list(keys), 4)}")
    return found[0]


def _vector(tree: YamlTree, where: str, value: Any, letters: Sequence[str]) -> Numbers:
    """As many numbers as letters, or names, given as a list or by these as keys; raises VehicleError."""
    if isinstance(value, dict):
        if set(value) != set(letters):
            raise mismatch(tree, where, listed(list(value)) or "no keys", ", ".join(letters))
        value = [value[letter] for letter in letters]
    vector = numbers(tree, where, value)
    if len(vector) != len(letters):
        raise mismatch(tree, where, f"{len(vector)} numbers", ", ".join(letters))
    return vector


def _directions(tree: YamlTree, way: str, given: Mapping[str, Any]) -> tuple[list[Numbers], str]:
    """Unit vectors (n, 3), and a sentence on what they were made of; raises VehicleError."""
    maps = {frozenset(value) if isinstance(value, dict) else None for value in given.values()}
    if way in ANGLES or maps == {frozenset(ROTATIONS)}:
        angles = [_vector(tree, where, value, ROTATIONS) for where, value in given.items()]
        unit = _unit(tree, way, angles)
        turns = np.radians(angles) if unit == "degrees" else [[exact_angle(a) for a in row] for row in angles]
        return _x_axes(Rotation.from_euler("xyz", turns)), (
            f"{way} is roll, pitch, yaw in {unit} about fixed axes; thrust is along x of the rotated frame."
        )
    if way in QUATERNIONS or maps == {frozenset("xyzw")}:
        order = QUATERNIONS.get(way, "") or "xyzw"
        for where, value in given.items():
            if not QUATERNIONS.get(way) and not isinstance(value, dict):
                remedy = "give x, y, z, w as keys, or call it quaternion_xyzw or quaternion_wxyz"
                raise mismatch(tree, where, "numbers in no stated order", "keys", remedy)
        quaternions = [_vector(tree, where, value, order) for where, value in given.items()]
        rows = [[quaternion[order.index(letter)] for letter in "xyzw"] for quaternion in quaternions]
        for where, row in zip(given, rows, strict=True):
            if abs(hypot(*row) - 1) > 1e-2:
                raise mismatch(tree, where, f"length {hypot(*row):g}", "1")
        return _x_axes(Rotation.from_quat(rows)), (
            f"{way} is a quaternion; thrust is along x of the rotated frame."
        )
    if way == "orientation":
        where = next(iter(given))
        remedy = "call it rpy_deg, rpy_rad, direction or quaternion_xyzw"
        raise mismatch(tree, where, "angles or a direction", "one of them by its key", remedy)
    vectors = [_vector(tree, where, value, "xyz") for where, value in given.items()]
    for where, vector in zip(given, vectors, strict=True):
        if not hypot(*vector) > SHORTEST:
            raise mismatch(tree, where, "0, 0, 0", "a direction x, y, z")
    return [[x / hypot(*vector) for x in vector] for vector in vectors], (
        f"{way} is where positive thrust pushes the vehicle."
    )


def _unit(tree: YamlTree, way: str, angles: list[Numbers]) -> str:
    """degrees or radians, by the key's name or by what the angles can be; raises VehicleError."""
    flat = [angle for row in angles for angle in row]
    if way in ("rpy_deg", "rpy_rad"):
        return "degrees" if way == "rpy_deg" else "radians"
    if max(map(abs, flat)) > 2 * np.pi:
        return "degrees"
    step = np.pi / 12
    if all(abs(exact_angle(a) - round(a / step) * step) < 1e-9 for a in flat):
        return "radians"
    raise VehicleError(f"{tree.path}: {way} may be in degrees or radians; call it rpy_deg or rpy_rad")


def _x_axes(turns: Rotation) -> list[Numbers]:
    """The x axes (n, 3) of rotated frames."""
    axes: list[Numbers] = np.round(turns.apply([1.0, 0.0, 0.0]), 15).tolist()
    return axes
