"""The thruster allocation matrix: ``TAM.yaml`` of uuv_simulator, and ``tam`` of ROS 2's auv_controllers.

uuv_simulator has six rows in the frame of base_link. auv_controllers has rows by name, x, y, z, rx, ry, rz or
roll, pitch, yaw, beside the thrusters' names; each thruster's limits stand in its own controller.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from alloc.errors import VehicleError
from alloc.files.textfile import read_text
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle.frame import described
from alloc.vehicle.geometry import DOF
from bench.inputs.columns import listed
from bench.inputs.draft import Draft, find, numbers, rows, with_comment

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
    return any(line.strip().startswith("tam:") for line in text.splitlines())


def read(path: Path) -> Draft:
    """The Draft of a TAM file, in the frame that a comment says; raises FileError or VehicleError."""
    return with_comment(_draft(path), read_text(path))


def _draft(path: Path) -> Draft:
    tree = read_yaml(path)
    tam = find(tree, "tam")
    if isinstance(tam, dict):
        return _by_name(tree, tam)
    T = rows(tree, "tam", tam)
    if len(T) != len(DOF):
        raise VehicleError(f"{path}: tam has {len(T)} rows{_transposed(T)}; give six, surge to yaw")
    draft = Draft(
        source=f"{path.name}, thruster allocation matrix of uuv_simulator", dof=DOF, T=T, frame="flu"
    )
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
        if turned := _transposed(list(tam.values())):
            raise VehicleError(f"{tree.path}: tam has {len(tam)} rows{turned}; give one by each axis's name")
        raise VehicleError(
            f"{tree.path}: tam has a row {unknown[0][:40]!r}; the rows are x, y, z, rx, ry, rz"
        )
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
    n = len(given[axes[0]])
    thrusters = find(tree, "thrusters")
    if (
        isinstance(thrusters, list)
        and len(thrusters) == n
        and all(isinstance(name, str) for name in thrusters)
    ):
        draft.names = [name.removesuffix("_joint")[:40] for name in thrusters]
    _limits(tree, draft, thrusters if draft.names else None, n)
    return draft


def _transposed(T: Sequence[Any]) -> str:
    """A clause that says it of rows that have six numbers each, as columns have; else empty."""
    turned = all(isinstance(row, list) and len(row) == len(DOF) for row in T)
    return (
        f" of six, one a thruster: it is transposed, {len(T)} columns of six are expected" if turned else ""
    )


class ManagerOptions(NamedTuple):
    """Options of thruster_manager: limits of every thruster [N], None where it has none, and their joints.

    Attributes
    ----------
    f_min, f_max : min_thrust and max_thrust [N]
    deadzone : thrusts within it of 0 are avoided where the matrix has a kernel [N]
    pattern : of the joints that are thrusters; empty where gz-sim's plug-ins say them
    """

    f_min: float | None
    f_max: float | None
    deadzone: float
    pattern: str


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


def _limits(tree: YamlTree, draft: Draft, thrusters: list[str] | None, n: int) -> None:
    """min_thrust and max_thrust of each thruster, by the name in its controller, or one for all."""
    controllers = [node for node in _maps(tree.data) if "min_thrust" in node or "max_thrust" in node]
    by_thruster = {str(node.get("thruster", "")): node for node in controllers}
    if thrusters is not None and all(name in by_thruster for name in thrusters):
        chosen = [by_thruster[name] for name in thrusters]
    elif len(controllers) == 1:
        chosen = controllers * n
    else:
        return
    for key, name in (("f_min", "min_thrust"), ("f_max", "max_thrust")):
        if all(name in node for node in chosen):
            values = numbers(tree, name, [node[name] for node in chosen])
            setattr(draft, key, values[0] if len(set(values)) == 1 else values)


def _maps(data: Any) -> Iterator[dict[str, Any]]:
    if isinstance(data, dict):
        yield data
        for value in data.values():
            yield from _maps(value)
