"""URDF, a robot's description in ROS: thruster joints or links, poses composed along the tree to the base.

Read by ROS's own parser (library urdfdom-py, extra ``urdf``), which is asked for links, masses and joints
only; meshes are never opened. Xacro is answered with the command that expands it.
"""

from collections.abc import Iterator
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import NotInstalled, VehicleError
from alloc.vehicle import LARGEST
from bench.inputs.description import Mass, Mount, along, make_draft, motors, pose, read_xml
from bench.inputs.draft import Draft, mismatch

BASE = "base_link"
PATTERN = True
"""``read`` takes a pattern of thrusters' names."""
LEFT_OUT = (
    "gz does not have these thrusters, as it leaves out links of a URDF without mass and all below them"
)
_PARTS = (
    "robot",
    "link",
    "inertial",
    "origin",
    "mass",
    "inertia",
    "joint",
    "parent",
    "child",
    "axis",
    "limit",
)
"""Elements that ROS's parser is given."""


def recognises(path: Path, text: str) -> bool:
    """True if the text is XML of a robot."""
    return "<robot" in text or "xacro" in "".join(path.suffixes)


def read(path: Path, pattern: str = "") -> Draft:
    """The Draft of a description; raises FileError, NotInstalled or VehicleError."""
    root = read_xml(path)
    found = motors(path, root)
    robot = _parsed(path, root)
    poses = _poses(path, robot)
    base = BASE if BASE in poses else next(iter(poses), "")
    if not base:
        raise VehicleError(f"{path}: holds no link; give the description of a robot")
    to_base = np.linalg.inv(poses[base]).astype(np.float64)
    return make_draft(
        path,
        "URDF",
        base,
        list(_mounts(path, robot, poses, to_base)),
        [_mass(path, link, to_base @ poses[link.name]) for link in robot.links if link.inertial is not None],
        found,
        pattern,
        [angle for joint in robot.joints if joint.origin for angle in joint.origin.rpy or ()],
    )


def _parsed(path: Path, root: Element) -> Any:
    """The links and joints as urdf_parser_py has them, which refuses or prints what it does not know."""
    try:
        from urdf_parser_py.urdf import URDF
    except ImportError:
        raise NotInstalled("reading URDF needs urdfdom-py; pip install 'thrustbench[urdf]'") from None
    for element in list(root.iter()):
        for child in list(element):
            known = child.tag in _PARTS and not (child.tag == "joint" and element is not root)
            if not known or (child.tag == "link" and element is not root):
                element.remove(child)
    try:
        with redirect_stderr(StringIO()):  # what it only remarks on does not matter here
            return URDF.from_xml_string(ElementTree.tostring(root))
    except Exception as error:  # it raises its own errors, assertions and whatever a value raised
        reason = " ".join(str(error).split())[:80]
        raise VehicleError(f"{path}: not a URDF that ROS's parser reads ({reason}); mend it") from None


def _poses(path: Path, robot: Any) -> dict[str, FloatArray]:
    """(4, 4) of each link from the root, all joints at 0; raises VehicleError for what is no tree."""
    names = [link.name for link in robot.links]
    children: dict[str, list[Any]] = {name: [] for name in names}
    for joint in robot.joints:
        for end in (joint.parent, joint.child):
            if end not in children:
                raise VehicleError(
                    f"{path}: joint {joint.name!r} names link {str(end)[:40]!r}, which is not there"
                )
        children[joint.parent].append(joint)
    carried = {joint.child for joint in robot.joints}
    level = [name for name in names if name not in carried][:1]
    poses = {name: np.eye(4) for name in level}
    while level:
        below = []
        for parent in level:
            for joint in children[parent]:
                if joint.child in poses:
                    raise VehicleError(f"{path}: link {joint.child!r} hangs on two joints; give a tree")
                poses[joint.child] = poses[parent] @ _origin(path, joint.name, joint.origin)
                below.append(joint.child)
        level = below
    if len(poses) < len(set(names)):
        lost = next(name for name in names if name not in poses)
        raise VehicleError(
            f"{path}: link {lost!r} does not hang on the tree of {next(iter(poses), 'any link')}"
        )
    return poses


def _mounts(path: Path, robot: Any, poses: dict[str, FloatArray], to_base: FloatArray) -> Iterator[Mount]:
    left_out = _links_left_out(robot)
    for joint in robot.joints:
        here = to_base @ poses[joint.child]
        axis = along(path, joint.name, joint.axis or [1.0, 0.0, 0.0])
        turns = joint.joint_type in ("continuous", "revolute")
        remark = LEFT_OUT if joint.child in left_out else ""
        yield Mount(joint.name, joint.child, here[:3, 3], here[:3, :3] @ axis, turns, remark)


def _links_left_out(robot: Any) -> set[str]:
    """Links that sdformat 12.3 leaves out of a URDF: without mass, or below such a link.

    Masses on fixed joints are first added to their parent.
    """
    masses = {link.name: (link.inertial.mass or 0.0) if link.inertial else 0.0 for link in robot.links}
    parents = {joint.child: joint for joint in robot.joints}
    above = {name: [name] for name in masses}  # from each link to the root, which _poses found to be a tree
    for chain in above.values():
        while chain[-1] in parents:
            chain.append(parents[chain[-1]].parent)
    lumped = dict.fromkeys(masses, 0.0)
    for name, chain in above.items():
        for link in chain:
            lumped[link] += masses[name]
            if link not in parents or parents[link].joint_type != "fixed":
                break
    return {
        name for name, chain in above.items() if any(lumped[link] <= 0 for link in chain if link != "world")
    }


def _mass(path: Path, link: Any, here: FloatArray) -> Mass:
    mass = float(link.inertial.mass or 0.0)
    if not 0 <= mass <= LARGEST:
        raise mismatch(path, f"mass of {link.name}", f"{mass:g}", "kg")
    return Mass(mass, (here @ _origin(path, link.name, link.inertial.origin))[:3, 3])


def _origin(path: Path, name: str, origin: Any) -> FloatArray:
    if origin is None:
        return np.eye(4)
    xyz, rpy = origin.xyz or [0, 0, 0], origin.rpy or [0, 0, 0]
    if not (np.abs([*xyz, *rpy]) <= LARGEST).all():
        raise mismatch(path, f"origin of {name}", "numbers that are not", f"finite ones up to {LARGEST:g}")
    return pose(xyz, rpy)
