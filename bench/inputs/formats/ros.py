"""ROS parameter files with ``thruster_position``/``thruster_force_direction`` or a ``configuration_matrix``.

The keys are those of vortex-auv (auv_setup/config/robots), at any depth. ROS 2 has no nested lists, so
its arrays are flat: all x, then all y, then all z of vectors; one row after the other of a matrix.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from alloc import Vehicle
from alloc.errors import VehicleError
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import Numbers, VehicleFile
from bench.inputs.draft import Draft, find, has_key, mismatch, numbers, rows
from bench.inputs.frames import frame_comment

POSITIONS = ("thruster_position", "thruster_positions")
DIRECTIONS = ("thruster_force_direction", "thruster_layout")
MATRIX = ("configuration_matrix", "thrust_configuration_matrix")

HELD = frozenset(
    {"dof", "frame", "T", "planar", "thrusters", "center_of_mass", "reaction_torque"}
    | {"f_min", "f_max", "weights", "H", "slack_weights"}
)
"""Keys of a vehicle file that the format holds, or makes T of."""


def recognises(path: Path, text: str) -> bool:
    """True if the text has a key of positions, directions or the matrix."""
    return has_key(text, *POSITIONS, *DIRECTIONS, *MATRIX)


def read(path: Path) -> Draft:
    """The Draft of a parameter file; raises FileError or VehicleError."""
    tree = _of_one_node(read_yaml(path))
    draft = Draft(source=f"{path.name}, ROS parameters")
    n = _count(tree)
    positions, directions = find(tree, *POSITIONS), find(tree, *DIRECTIONS)
    if (positions is None) != (directions is None):
        raise mismatch(tree, POSITIONS[0], f"it or {DIRECTIONS[0]} alone", "both")
    if positions is not None:
        draft.positions = _vectors(tree, POSITIONS[0], positions)
        draft.directions = _vectors(tree, DIRECTIONS[0], directions)
        if len(draft.positions) != len(draft.directions):
            raise VehicleError(f"{path}: {POSITIONS[0]} and {DIRECTIONS[0]} differ in length; give one each")
    draft.dof = _dof(tree)
    if (matrix := find(tree, *MATRIX)) is not None:
        draft.T = rows(tree, MATRIX[0], matrix, n)
    if (center := find(tree, "center_of_mass")) is not None and positions is not None:
        draft.center_of_mass = numbers(tree, "center_of_mass", center)
        draft.assumptions.append("center_of_mass is in m.")
    _limits(tree, draft)
    for key, name in (("weights", "input_matrix_weights"), ("slack_weights", "slack_matrix_weights")):
        if (value := find(tree, name)) is not None:
            setattr(draft, key, numbers(tree, name, value))
    return draft


def places(data: Any, name: str, within: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Below which keys one of that name stands, from outermost to innermost: an entry for each time."""
    if not isinstance(data, dict):
        return []
    inner = (places(value, name, (*within, str(key))) for key, value in data.items())
    return [*([within] if name in data else []), *(place for found in inner for place in found)]


def _of_one_node(tree: YamlTree) -> YamlTree:
    """The part of a file with the thrusters, of several nodes; raises VehicleError where two have some."""
    found = {name: places(tree.data, name) for name in (*POSITIONS, *DIRECTIONS, *MATRIX)}
    for name, stands in found.items():
        if len(stands) > 1:
            one, two = (".".join(place) for place in stands[:2])
            raise VehicleError(
                f"{tree.path}: {name} stands below {one!r} and {two!r}; keep one vehicle's part"
            )
    owners = {"/**"} | {place[0] for stands in found.values() for place in stands if place}
    others = [part for name, part in tree.data.items() if name not in owners] if len(owners) > 1 else []
    # Another node's parameters, as a controller's max_force, are no thrusters'.
    if others and all(isinstance(part, dict) and "ros__parameters" in part for part in others):
        return replace(tree, data={name: part for name, part in tree.data.items() if name in owners})
    return tree


def write(keys: VehicleFile, vehicle: Vehicle) -> str:
    """The vehicle as a ROS 2 parameter file: poses where the vehicle file has nothing else, else T."""
    if np.count_nonzero(vehicle.H - np.diag(vehicle.H.diagonal())):
        raise VehicleError(f"{keys.name}: H is not diagonal, which ROS parameters can't say; export csv")
    # ROS files say which axes there are, but no order: it is surge to yaw.
    order = [vehicle.dof.index(axis) for axis in DOF if axis in vehicle.dof]
    # T goes before poses: the vehicle allocates by it, and poses leave out a propeller's own moment.
    if keys.thrusters is None or keys.T is not None or keys.reaction_torque:
        geometry = [
            f"        configuration_matrix: {_array(vehicle.T[order].ravel())}  # rows, one after the other"
        ]
        center = ""
    else:
        vectors = [[t.position for t in keys.thrusters], [t.direction for t in keys.thrusters]]
        geometry = [
            f"        {name}: {_array(np.array(v).T.ravel())}  # all x, all y, all z"
            for name, v in zip((POSITIONS[0], DIRECTIONS[0]), vectors, strict=True)
        ]
        center = f"    physical:\n      center_of_mass: {_array(keys.center_of_mass)}\n"
    which = "".join(f"          {axis}: {str(axis in keys.dof).lower()}\n" for axis in DOF)
    return (
        f"# {keys.name}, written by thrustbench\n{frame_comment(vehicle.frame)}"
        "/**:\n  ros__parameters:\n"
        f"{center}"
        "    propulsion:\n"
        f"      dofs:\n        num: {vehicle.k}\n        which:\n{which}"
        f"      thrusters:\n        num: {vehicle.n}\n" + "\n".join(geometry) + "\n        constraints:\n"
        f"          min_force: {_array(vehicle.f_min)}\n"
        f"          max_force: {_array(vehicle.f_max)}\n"
        f"          input_matrix_weights: {_array(vehicle.H.diagonal())}\n"
        f"          slack_matrix_weights: {_array(vehicle.slack_weights[order])}\n"
    )


def _vectors(tree: YamlTree, key: str, value: Any) -> list[Numbers]:
    """Vectors (n, 3) given as n rows of three, or flat: all x, all y, all z; raises VehicleError."""
    if isinstance(value, list) and value and all(isinstance(row, list) for row in value):
        matrix = rows(tree, key, value)
        if len(matrix[0]) != 3:
            raise mismatch(tree, key, f"rows of {len(matrix[0])} numbers", "x, y, z")
        return matrix
    flat = numbers(tree, key, value)
    if not flat or len(flat) % 3:
        raise mismatch(tree, key, f"{len(flat)} numbers", "all x, all y, all z")
    vectors: list[Numbers] = np.reshape(flat, (3, -1)).T.tolist()
    return vectors


def _count(tree: YamlTree) -> int | None:
    thrusters = find(tree, "thrusters")
    count = thrusters.get("num") if isinstance(thrusters, dict) else None
    return count if isinstance(count, int) else None


def _dof(tree: YamlTree) -> tuple[str, ...]:
    which = find(tree, "which")
    return tuple(axis for axis in DOF if which.get(axis)) if isinstance(which, dict) else ()


def _limits(tree: YamlTree, draft: Draft) -> None:
    for key, names in (("f_min", ("min_force", "min_thrust")), ("f_max", ("max_force", "max_thrust"))):
        value = find(tree, *names)
        if value is not None:
            listed = numbers(tree, names[0], value if isinstance(value, list) else [value])
            setattr(draft, key, listed if isinstance(value, list) else listed[0])
    table = find(tree, "characteristics")
    if draft.f_max is None and isinstance(table, dict) and "thrust" in table:
        thrusts = numbers(tree, "characteristics.thrust", table["thrust"]) or [0.0]
        draft.f_min, draft.f_max = min(thrusts), max(thrusts)
        draft.limits_assumed.append("Limits are the ends of characteristics.thrust.")


def _array(values: Any) -> str:
    # float() keeps the decimal point, since ROS 2 wants one type in an array; + 0.0 turns -0.0 into 0.0.
    return "[" + ", ".join(repr(float(x) + 0.0) for x in values) + "]"
