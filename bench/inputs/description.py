"""Thrusters out of a robot's description, URDF or SDF: what pushes where, in the frame of its base."""

import re
from collections.abc import Iterable, Mapping, Sequence
from math import hypot, trunc
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from alloc.allocation import FloatArray
from alloc.errors import FileError, NotInstalled, VehicleError
from alloc.files.textfile import read_text
from alloc.vehicle import LARGEST
from alloc.vehicle.geometry import DOF
from alloc.vehicle.names import is_index
from bench.inputs.columns import listed
from bench.inputs.draft import Draft, mismatch

SHORTEST = 1e-9
"""Length from which a vector has a direction."""
USUAL = ".*(thruster|propeller).*"
"""Names of thrusters where neither a plug-in nor the user says them, in any case."""
STEPS = {2: np.pi / 2, **dict.fromkeys(range(3, 16), np.pi / 12)}
"""By decimals of an angle [rad], the step whose multiples it may round: 1.57 a right angle, 0.785 also 45
degrees."""


LONGEST = 5_000_000  # bytes; a robot's description has some hundred thousand
DEEPEST = 100


class Mass(NamedTuple):
    """A link's mass [kg] and where it is, (3,) from the base [m]."""

    mass: float
    center: FloatArray


class Mount(NamedTuple):
    """A joint or a link that may be a thruster.

    Attributes
    ----------
    joint, link : names of the joint, empty for a link without one, and of the link that it carries
    position : (3,) from the base [m]
    direction : (3,) of its axis, of unit length [-]
    turns : whether the joint can turn, as a propeller's does
    remark : a clause on what gz makes of it, where that is not what the file seems to say
    """

    joint: str
    link: str
    position: FloatArray
    direction: FloatArray
    turns: bool
    remark: str = ""


class Motor(NamedTuple):
    """Limits that gz-sim's thruster plug-in gives a joint: the ends of its thrust [N], None for none.

    ``mirrored`` says that it has no end astern, so that the one ahead is taken for both.
    """

    f_min: float | None
    f_max: float | None
    mirrored: bool = False


def pose(xyz: Sequence[float], rpy: Sequence[float]) -> FloatArray:
    """(4, 4) pose of a position [m] and of roll, pitch, yaw about fixed axes [rad], as they are meant."""
    return make_pose(xyz, Rotation.from_euler("xyz", [exact_angle(angle) for angle in rpy]).as_matrix())


def exact_angle(angle: float) -> float:
    """The angle [rad] that a description rounds or cuts off: pi/2 for 1.5708, any other as it is.

    With 1.5708 a vertical thruster pushes ahead with 4e-6 of its thrust. Where a failure leaves nothing that
    makes up for that, no heave meets its demand exactly.
    """
    for decimals, step in STEPS.items():
        exact = round(angle / step) * step
        scaled = exact * 10**decimals
        if angle != exact and angle in (round(scaled) / 10**decimals, trunc(scaled) / 10**decimals):
            return exact
    return angle


def make_pose(xyz: Sequence[float], turn: FloatArray) -> FloatArray:
    """(4, 4) pose of a position [m] and a rotation (3, 3)."""
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn, xyz
    return made


def numbers(path: Path, where: str, text: str | None, count: int) -> list[float]:
    """``count`` finite numbers out of an element's text; raises VehicleError that names it."""
    words = (text or "").split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) <= LARGEST for value in values):
        raise mismatch(path, where, repr((text or "").strip()[:40]), f"{count} finite numbers")
    return values


def along(path: Path, joint: str, axis: Sequence[float]) -> FloatArray:
    """(3,) a joint's axis in unit length; raises VehicleError where it has no direction."""
    length = hypot(*axis) if len(axis) == 3 else 0.0
    if not SHORTEST < length <= LARGEST:
        raise VehicleError(f"{path}: the axis of joint {joint[:40]!r} has no direction; give x y z")
    unit: FloatArray = np.array(axis, dtype=np.float64) / length
    return unit


def motors(path: Path, root: Element) -> dict[str, Motor]:
    """By joint, what gz-sim's thruster plug-ins say: limits, or what their coefficients make of a speed.

    thrust = coefficient rho D^4 (omega / 2 pi)^2 (Fossen 2011, eq. 12.258), as the plug-in has it.
    """
    found = {}
    for plugin in root.iter("plugin"):
        named = f"{plugin.get('filename', '')} {plugin.get('name', '')}"
        joint = (plugin.findtext("joint_name") or "").strip()
        if not re.search(r"thruster-system|systems::Thruster", named) or not joint:
            continue

        def value(key: str, default: float | None, plugin: Element = plugin) -> float | None:
            text = plugin.findtext(key)
            return default if text is None else numbers(path, key, text, 1)[0]

        high = value("max_thrust_cmd", None)
        low = value("min_thrust_cmd", None if high is None else -abs(high))
        if (plugin.findtext("use_angvel_cmd") or "").strip() in ("true", "1"):
            coefficient, density = value("thrust_coefficient", 1.0), value("fluid_density", 1000.0)
            diameter = value("propeller_diameter", 0.02)
            assert coefficient is not None
            assert density is not None
            assert diameter is not None
            full = coefficient * density * diameter**4 / (2 * np.pi) ** 2
            ends = [None if speed is None else full * abs(speed) * speed for speed in (low, high)]
            if ends[0] is not None and ends[1] is not None and full < 0:
                ends.reverse()
            low, high = ends
        found[joint] = Motor(low, high, plugin.find("min_thrust_cmd") is None)
    return found


def has_thrusters(names: Iterable[str], found: Mapping[str, Motor], pattern: str) -> bool:
    """True if plug-ins, or a pattern of the names of joints and links, make something a thruster."""
    meant = _meant(pattern)
    return bool(found and not pattern) or any(meant.fullmatch(name) for name in names)


def make_draft(
    path: Path,
    kind: str,
    base: str,
    mounts: Sequence[Mount],
    masses: Sequence[Mass],
    found: Mapping[str, Motor],
    pattern: str,
    angles: Iterable[float],
) -> Draft:
    """The Draft of a description; raises VehicleError with the names there are where none is a thruster's.

    Parameters
    ----------
    path, kind : the file, and what it is
    base : in words, the frame of ``mounts`` and ``masses``
    found : of gz-sim's plug-ins, by joint
    pattern : that the names of thrusters match as a whole; empty for those of plug-ins, or the usual names
    angles : of poses, as they are written [rad]
    """
    chosen, why = _chosen(path, mounts, found, pattern)
    draft = Draft(source=f"{path.name}, {kind}", dof=DOF, frame="flu")
    draft.frame_assumed = f"The frame is that of {base}, flu as everywhere in ROS and gz: x ahead, z up."
    draft.positions = [mount.position.tolist() for mount in chosen]
    draft.directions = [np.round(mount.direction, 15).tolist() for mount in chosen]
    draft.names = [_name(mount) for mount in chosen]
    draft.assumptions.append(f"{why}; positive thrust pushes along the axis of its joint, as in gz-sim.")
    for remark in dict.fromkeys(mount.remark for mount in chosen if mount.remark):
        theirs = [mount.joint for mount in chosen if mount.remark == remark]
        draft.assumptions.append(f"{remark}: {listed(theirs)}.")
    if rounded := sorted({f"{angle:g}" for angle in angles if exact_angle(angle) != angle}):
        draft.assumptions.append(
            f"Angles of {listed(rounded, 6)} rad are taken for the multiples of 15 degrees that they round."
        )
    total = sum(one.mass for one in masses)
    if total > 0:
        center = sum((one.mass * one.center for one in masses), np.zeros(3)) / total
        draft.center_of_mass = center.tolist()
        draft.assumptions.append(f"The centre of mass is that of all links, {total:.4g} kg.")
    else:
        draft.assumptions.append("No link has a mass: the centre of mass is taken at the base.")
    limits = [found.get(mount.joint, Motor(None, None)) for mount in chosen]
    mirrored = "It has no min_thrust_cmd: as much astern as ahead is assumed."
    draft.set_limits(
        [motor.f_min for motor in limits],
        [motor.f_max for motor in limits],
        "Limits are those of gz-sim's thruster plug-in.",
        *([mirrored] if any(motor.mirrored for motor in limits) else []),
    )
    return draft


def _chosen(
    path: Path, mounts: Sequence[Mount], found: Mapping[str, Motor], pattern: str
) -> tuple[list[Mount], str]:
    """The mounts that are thrusters, and what tells so."""
    if not pattern and found:
        by_joint = {mount.joint: mount for mount in mounts}
        if missing := [joint for joint in found if joint not in by_joint]:
            raise VehicleError(
                f"{path}: a thruster plug-in names joint {missing[0][:40]!r}, which is not there"
            )
        return [by_joint[joint] for joint in found], "The thrusters are those of gz-sim's plug-ins"
    meant = _meant(pattern)
    joints = [mount for mount in mounts if mount.joint and meant.fullmatch(mount.joint)]
    links = [mount for mount in mounts if meant.fullmatch(mount.link)]
    # A propeller's joint turns; what is fixed may be the bracket that carries it.
    for kind in ([m for m in joints if m.turns], [m for m in links if m.turns], joints, links):
        if kind:
            return kind, f"The thrusters are what {pattern or 'thruster or propeller'!r} names"
    names = listed([name for mount in mounts for name in (mount.joint, mount.link) if name], 20)
    if not names:
        raise VehicleError(f"{path}: has no joints, so no thrusters; give a description that has them")
    raise VehicleError(
        f"{path}: {pattern or 'thruster or propeller'!r} names none of {names}; say which with"
        " --thruster PATTERN, as in '.*prop.*'"
    )


def _meant(pattern: str) -> re.Pattern[str]:
    try:
        return re.compile(pattern or USUAL, 0 if pattern else re.IGNORECASE)
    except re.error as error:
        raise VehicleError(
            f"--thruster {pattern[:40]!r}: no pattern ({error}); give one as '.*thruster.*'"
        ) from None


def _name(mount: Mount) -> str:
    """A joint's name without the word joint, as people call the thruster."""
    name = re.sub(r"[_ -]*joint$", "", mount.joint or mount.link) or mount.joint
    kept = re.sub(r'[@,"/]', "-", name)[:40].strip()
    return f"thruster {kept}" if is_index(kept) or kept in ("", "each") else kept


def read_xml(path: Path) -> Element:
    """The root of a file; raises FileError, NotInstalled, and VehicleError for xacro, which is none yet."""
    text = read_text(path, LONGEST)
    try:
        from defusedxml import ElementTree
        from defusedxml.common import DefusedXmlException
    except ImportError:
        raise NotInstalled("reading URDF and SDF needs defusedxml; pip install 'thrustbench[urdf]'") from None
    try:
        root: Element = ElementTree.fromstring(text.encode(), forbid_dtd=True)
    except DefusedXmlException as error:
        raise FileError(
            f"holds {type(error).__name__}; take out <!DOCTYPE> and entities", path=path
        ) from None
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # ValueError: an unknown encoding
        line = getattr(error, "position", (None,))[0]
        raise FileError(f"not XML ({str(error)[:60]}); mend it", path=path, line=line) from None
    if _depth(root) > DEEPEST:
        raise FileError(f"is nested deeper than {DEEPEST} elements; a robot's description is not", path=path)
    if any("xacro" in str(element.tag) for element in root.iter()) or "$(" in text or "${" in text:
        stem = path.name.partition(".")[0]
        # A shell empties the target before xacro reads: it must be another file.
        target = f"{stem}-expanded.urdf" if path.name == f"{stem}.urdf" else f"{stem}.urdf"
        raise VehicleError(f"{path}: is xacro, which makes a description; expand it: xacro {path} > {target}")
    return root


def _depth(root: Element) -> int:
    deepest, level = 0, [root]
    while level and deepest <= DEEPEST:
        deepest, level = deepest + 1, [child for element in level for child in element]
    return deepest
