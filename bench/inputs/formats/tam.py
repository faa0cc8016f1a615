"""The thruster allocation matrix: ``TAM.yaml`` of uuv_simulator, and ``tam`` of ROS 2's auv_controllers.

uuv_simulator has six rows in the frame of base_link. auv_controllers has rows by name, x, y, z, rx, ry, rz or
roll, pitch, yaw, beside the thrusters' names; each thruster's limits stand in its own controller.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from alloc.errors import VehicleError
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle.frame import described
from alloc.vehicle.geometry import DOF
from bench.inputs.columns import listed
from bench.inputs.draft import Draft, ends, find, has_key, mismatch, numbers, rows

ROWS = {
    "surge": ("x", "surge"),
    "sway": ("y", "sway"),
    "heave": ("z", "heave"),
    "roll": ("rx", "roll"),
    "pitch": ("ry", "pitch"),
    "yaw": ("rz", "yaw"),
}
"""Names of each row in auv_controllers."""
OPTIONS = (
    "min_thrust",
    "max_thrust",
    "deadzone",
    "thruster_prefix",
    "thrusters",
    "use_gz_plugin",
    "publish_thrusts",
)
"""Keys of ``tam`` in thruster_manager, which has no matrix there."""


def recognises(path: Path, text: str) -> bool:
    """True if the text has a key ``tam``."""
    return has_key(text, "tam")


def read(path: Path) -> Draft:
    """The Draft of a TAM file; raises FileError or VehicleError."""
    tree = read_yaml(path)
    tam = find(tree, "tam")
    if isinstance(tam, dict):
        return _by_name(tree, tam)
    T = rows(tree, "tam", tam)
    if len(T) != len(DOF):
        raise mismatch(tree, "tam", *_miscounted(T))
    draft = Draft(source=f"{path.name}, thruster allocation matrix of uuv_simulator", dof=DOF, T=T)
    draft.frame = "flu"
    draft.frame_assumed = "The frame is base_link, flu: x ahead, y to port, z up."
    if (limit := find(tree, "max_thrust")) is not None:
        draft.f_max = numbers(tree, "max_thrust", [limit])[0]
        draft.f_min = -draft.f_max
        draft.limits_assumed.append("max_thrust holds both ways.")
    return draft


def _by_name(tree: YamlTree, tam: dict[str, Any]) -> Draft:
    known = {name: axis for axis, names in ROWS.items() for name in names}
    if options := [key for key in OPTIONS if key in tam]:
        raise VehicleError(
            f"{tree.path}: tam has {listed(options)}, options of thruster_manager, whose matrix comes from a"
            f" URDF; thrustbench import model.urdf --limits {tree.path.name}"
        )
    if unknown := [key for key in tam if key not in known]:
        if _is_transposed(list(tam.values())):
            raise mismatch(tree, "tam", *_miscounted(list(tam.values())))
        raise mismatch(tree, "tam", f"a row {unknown[0][:40]!r}", "rows x, y, z, rx, ry, rz")
    given = {known[key]: numbers(tree, f"tam.{key}", row) for key, row in tam.items()}
    if len(given) < len(tam) or not given or len({len(row) for row in given.values()}) != 1:
        raise VehicleError(
            f"{tree.path}: rows of tam differ in length or stand twice; give one entry a thruster"
        )
    axes = tuple(axis for axis in DOF if axis in given)
    draft = Draft(source=f"{tree.path.name}, ROS parameters tam", dof=axes, T=[given[axis] for axis in axes])
    draft.frame_assumed = (
        f"The file names no frame: {described('frd')} is taken, as auv_controllers' own vehicles have it;"
        " --frame flu if z is up."
    )
    names, n = find(tree, "thrusters"), len(given[axes[0]])
    is_named = isinstance(names, list) and len(names) == n and all(isinstance(name, str) for name in names)
    draft.names = [name.removesuffix("_joint")[:40] for name in names] if is_named else None
    controllers = [node for node in _maps(tree.data) if "min_thrust" in node or "max_thrust" in node]
    of_each = {str(node.get("thruster", "")): node for node in controllers}
    own: list[dict[str, Any] | None] = [of_each.get(name) for name in names] if is_named else [None]
    if None in own and len(controllers) == 1:
        own = [controllers[0]] * n
    if None not in own:
        low, high = (ends(tree, own, key, key) for key in ("min_thrust", "max_thrust"))
        draft.set_limits(low, high)
    return draft


def _is_transposed(T: Sequence[Any]) -> bool:
    """True for rows that have six numbers each, as columns have."""
    return all(isinstance(row, list) and len(row) == len(DOF) for row in T)


def _miscounted(T: Sequence[Any]) -> tuple[str, str, str]:
    """The rows that a matrix has, those expected, and the remedy."""
    if _is_transposed(T):
        return f"{len(T)} rows of six, one a thruster", "six rows, surge to yaw", "it is transposed"
    return f"{len(T)} rows", "six, surge to yaw", ""


class ManagerOptions(NamedTuple):
    """Options of thruster_manager: limits of every thruster [N], None where it has none, and their joints.

    Attributes
    ----------
    f_min, f_max : min_thrust and max_thrust [N]
    deadzone : thrusts within it of 0 are avoided where the matrix has a kernel [N]
    pattern : of the joints that are thrusters; empty where gz-sim's plug-ins say them
    """

    f_min: float | None = None
    f_max: float | None = None
    deadzone: float = 0.0
    pattern: str = ""


def read_options(path: Path) -> ManagerOptions:
    """Read the options of thruster_manager's ``tam``; raises FileError or VehicleError.

    CentraleNantesROV/thruster_manager @04cedad, src/thruster_manager.cpp: limits of 0 are none, and limits
    hold only where both are given.
    """
    tree = read_yaml(path)
    tam = find(tree, "tam")
    if not isinstance(tam, dict) or not any(key in OPTIONS for key in tam):
        raise VehicleError(f"{path}: has no tam with {', '.join(OPTIONS[:3])}; give thruster_manager's file")
    low, high, dead = (
        numbers(tree, f"tam.{key}", [tam.get(key, 0.0)])[0]
        for key in ("min_thrust", "max_thrust", "deadzone")
    )
    joints, prefix = tam.get("thrusters", []), tam.get("thruster_prefix", "")
    if not isinstance(joints, list) or not isinstance(prefix, str):
        raise VehicleError(
            f"{path}: tam.thrusters is a list of joints, tam.thruster_prefix a text; mend them"
        )
    parts = [re.escape(str(joint)) for joint in joints] + ([re.escape(prefix) + ".*"] if prefix else [])
    given = low != 0 and high != 0
    return ManagerOptions(low if given else None, high if given else None, dead, "|".join(parts))


def _maps(data: Any) -> Iterator[dict[str, Any]]:
    if isinstance(data, dict):
        yield data
        for value in data.values():
            yield from _maps(value)
