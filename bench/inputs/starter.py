"""Files to start from: a vehicle in words of its own, demands on it, and a plug-in."""

import re
from collections.abc import Sequence
from importlib.resources import files
from typing import NamedTuple

import msgspec
import numpy as np

from alloc import Vehicle, alpha_max
from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from alloc.vehicle.file import matrices, poses, reaction_torques
from alloc.vehicle.frame import TURN
from alloc.vehicle.geometry import DOF, pose_matrix
from alloc.vehicle.keys import Thruster, VehicleFile, to_yaml
from bench.inputs.demand_csv import csv_text
from bench.inputs.frames import frame_comment

COMMENTS = {
    "source": "where your numbers come from: tape measure, CAD, the maker's table",
    "dof": "what you control, in the order of your demands",
    "frame": "of all here and of every demand; frd: y to starboard, z down; flu, ROS: y to port, z up",
    "thrusters": "position [m], and the direction in which positive thrust pushes the vehicle",
    "T": "rows as in dof; forces [-], moments [m]",
    "reaction_torque": "[m], each propeller's own moment along its thrust, for 1 N",
    "suspect": "thrusters whose column of T is taken as published, though none can make it",
    "center_of_mass": "[m], from the same point as the positions",
    "f_min": "[N] astern; one number, or a list with one a thruster",
    "f_max": "[N] ahead",
    "priority": "levels for the method `priority`: what must hold, first",
    "groups": "what the method `scaled-by-group` scales together",
    "weights": "effort of each thruster, the diagonal of H",
    "volts": "V: [f_min, f_max]; limits by the battery's voltage, linear between",
    "esc": "what goes to the ESCs: neutral, range, step, reversed, dead_band, and the measured curve",
    "survey": "how well poses are known: mm and deg",
    "weak": "auto: methods with a share leave out what the survey could make of nothing; 0: never",
    "slew": "[N/s], how fast thrusts may change",
}
FIRST = ("name", "source", "dof", "frame", "thrusters", "T", "center_of_mass", "f_min", "f_max")
"""Order of the keys that nearly every file has; the others follow."""
PLUGIN = '''"""{words}: the pseudoinverse, each thrust cut at its limit. Put your own in its place."""

import numpy as np

LIMITED = True  # every thrust lies inside the limits; leave it out where yours may not


def build(vehicle):
    G = np.linalg.pinv(vehicle.TP)  # what depends on the vehicle alone, once

    def allocate(tau):  # at the control rate: a wrench (k,) [N, N m] in, thrusts (n,) [N] out
        return np.clip(G @ tau, vehicle.f_min, vehicle.f_max)

    return allocate
'''
TURNING = (
    ("the pseudoinverse, each thrust cut at its limit", "the pseudoinverse"),
    (
        "LIMITED = True  # every thrust lies inside the limits; leave it out where yours may not",
        "AZIMUTHS = True  # f has two forces of a thruster that turns: vehicle.actuators\n"
        "LIMITED = False  # True where every force lies in its polygon: vehicle.half_planes",
    ),
    ("np.clip(G @ tau, vehicle.f_min, vehicle.f_max)", "G @ tau"),
)
"""Parts of the plug-in, and those in their place for a vehicle whose thrusters turn."""
SAME_T = 0.01
"""Largest difference, of a row's largest entry, at which poses stand for a published T of three digits."""


def copy_keys(name: str, keys: VehicleFile, origin: str) -> VehicleFile:
    """The keys of a vehicle that starts as a copy of another: poses with names, in the other's frame.

    T is kept where no poses make it, as of a published T whose moments contradict each other. Thrusters of a
    file in which some turn stay as they are.
    """
    source = f"copied from {origin}; no number is measured yet"
    if any(thruster.azimuth for thruster in keys.thrusters or ()):
        return msgspec.structs.replace(keys, name=name, source=source, notes=[])
    T, _ = matrices(keys)
    positions, directions, center, *_ = poses(keys, T)
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    unit = directions / np.where(lengths > 0, lengths, 1.0)
    moments = reaction_torques(keys, len(positions))
    made = pose_matrix(positions, unit, center, moments)[[DOF.index(axis) for axis in keys.dof]]
    off = np.abs(made - T).max(axis=1) / np.abs(T).max(axis=1).clip(min=1e-9)
    names = _own_names(keys) or name_places(positions - center, unit, keys.frame or "frd")
    copied = msgspec.structs.replace(keys, name=name, source=source, notes=[])
    if off.max() > SAME_T:
        return msgspec.structs.replace(
            copied,
            T=_rounded(T),
            thrusters=None,
            planar=None,
            names=list(_own_names(keys)) or None,
            center_of_mass=(0.0, 0.0, 0.0),
        )
    return msgspec.structs.replace(
        copied,
        T=None,
        planar=None,
        names=None,
        suspect=[],
        thrusters=_thrusters(names, positions, unit),
        center_of_mass=_three(center),
    )


def sketch_keys(
    name: str, length: float, width: float, angle: float, vertical: int, ahead: float, astern: float
) -> VehicleFile:
    """The keys of a vehicle told in a few words: four horizontal thrusters at its corners, and vertical ones.

    Parameters
    ----------
    name : of the vehicle
    length, width : between thrusters fore and aft, port and starboard [m]
    angle : of the horizontal thrusters from the longitudinal axis [deg]; 0: two of them, amidships
    vertical : vertical thrusters: 0, 1 in the middle, 2 at the sides, 4 at the corners
    ahead, astern : full thrust of each [N]

    Raises VehicleError for a number that no vehicle has.
    """
    for what, value in (("length", length), ("width", width), ("thrust", ahead)):
        if not 0 < value < np.inf:
            raise VehicleError(f"{what}: {value:g} is none of a vehicle; give a number above 0")
    if vertical not in (0, 1, 2, 4) or not 0 <= angle < 90 or not 0 <= astern < np.inf:
        raise VehicleError("vertical thrusters are 0, 1, 2 or 4, an angle is 0 to 89 deg, thrust from 0 N on")
    x, y = length / 2, width / 2
    c, s = float(np.cos(np.radians(angle))), float(np.sin(np.radians(angle)))
    corners = np.array([[x, y, 0], [x, -y, 0], [-x, y, 0], [-x, -y, 0]])
    if angle:
        positions, directions = corners, np.array([[c, -s, 0], [c, s, 0], [c, s, 0], [c, -s, 0]])
    else:
        positions, directions = corners[:2] * [0, 1, 1], np.tile([1.0, 0.0, 0.0], (2, 1))
    lift = {0: np.zeros((0, 3)), 1: np.zeros((1, 3)), 2: corners[:2] * [0, 1, 1], 4: corners}[vertical]
    positions = np.vstack([positions, lift])
    directions = np.vstack([directions, np.tile([0.0, 0.0, 1.0], (len(lift), 1))])
    T = pose_matrix(positions, directions)
    moved = [axis for axis, row in zip(DOF, T, strict=True) if np.abs(row).max() > 1e-9]
    return VehicleFile(
        name=name,
        source="sketched; no number is measured yet",
        dof=moved,  # type: ignore[arg-type]  # names out of DOF, which are the Literal's
        thrusters=_thrusters(name_places(positions, directions), positions, directions),
        f_min=-astern,
        f_max=ahead,
    )


def keys_text(keys: VehicleFile) -> str:
    """The text of a vehicle file, each key with what it means."""
    blocks: dict[str, list[str]] = {}
    key = ""
    for line in to_yaml(keys).splitlines():
        key = key if line.startswith(" ") else line.partition(":")[0]
        blocks.setdefault(key, []).append(line)
    blocks.setdefault("frame", ["frame: frd"])  # the defaults that a newcomer should see
    if keys.thrusters is not None:
        blocks.setdefault("center_of_mass", ["center_of_mass: [0, 0, 0]"])
    lines = [
        f"# `thrustbench check {keys.name}.yaml` draws this vehicle and says what looks wrong about it.",
        "# Put your own numbers in; docs/your-vehicle.md explains each key.",
    ]
    for key in sorted(blocks, key=lambda key: FIRST.index(key) if key in FIRST else len(FIRST)):
        first, *others = blocks[key]
        lines += [f"{first}  # {COMMENTS[key]}" if key in COMMENTS else first, *others]
    return "\n".join(lines) + "\n"


def first_demands(vehicle: Vehicle) -> str:
    """A CSV of demands: each axis alone, then all together within what the vehicle can do, and beyond it."""
    alone = 0.3 * np.diag(_finite(alpha_max(vehicle, np.eye(vehicle.k))))
    both = (alone.sum(axis=0) / 0.3)[None, :]
    most = _finite(alpha_max(vehicle, both))[0]
    taus = np.vstack([alone, 0.9 * most * both, 1.5 * most * both])
    rows = [[f"{0.1 * i:.1f}", *(f"{value + 0.0:.4g}" for value in tau)] for i, tau in enumerate(taus)]
    return frame_comment(vehicle.frame) + csv_text(("t", *vehicle.dof), rows)


class Language(NamedTuple):
    """A language to write a method in.

    Attributes
    ----------
    files : to start from, the one to write in first
    build : the command that makes the method of them; empty where there is nothing to make
    method : the file that is the method
    """

    files: tuple[str, ...]
    build: str
    method: str


LANGUAGES = {
    "python": Language(("my_allocator.py",), "", "my_allocator.py"),
    "c": Language(
        ("my_allocator.c",),
        "cc -std=c99 -O2 -shared -fPIC my_allocator.c -o my_allocator.so",
        "my_allocator.so",
    ),
    "cpp": Language(
        ("my_allocator.cpp", "CMakeLists.txt"),
        "cmake -B build && cmake --build build",
        "build/my_allocator.so",
    ),
    "rust": Language(
        ("src/lib.rs", "Cargo.toml"),
        "cargo build --release && cp target/release/libmy_allocator.so my_allocator.so",
        "my_allocator.so",
    ),
    "exec": Language(("my_allocator",), "", "./my_allocator"),
}
INTERFACE = ("c", "cpp")
"""Languages that include the C interface."""


def plugin(words: str, language: str = "python", *, azimuths: bool = False) -> dict[str, str]:
    """The files of a method to start from, as {file name: text}; ``azimuths`` where thrusters turn."""
    if language == "python":
        text = PLUGIN.format(words=words)
        for fixed, turning in TURNING if azimuths else ():
            text = text.replace(fixed, turning)
        return {"my_allocator.py": text}
    folder = files("alloc.foreign")
    found = {name: folder / "starters" / language / name for name in LANGUAGES[language].files}
    if language in INTERFACE:
        found["thrustbench_allocator.h"] = folder / "thrustbench_allocator.h"
    return {name: file.read_text(encoding="utf-8") for name, file in found.items()}


def check_name(name: str) -> str:
    """The name, where it may be a file's and a vehicle's; raises VehicleError."""
    if not re.fullmatch(r"[A-Za-z][\w.-]{0,39}", name, flags=re.ASCII):
        raise VehicleError(f"{name[:60]!r}: a name is up to 40 letters, digits, '-' and '_', a letter first")
    return name


def name_places(arms: FloatArray, directions: FloatArray, frame: str = "frd") -> list[str]:
    """Names of thrusters by where they sit (n, 3) [m] and which way they push (n, 3), each its own."""
    arms = arms * TURN if frame == "flu" else arms
    reach = np.abs(arms).max(axis=0)
    names = []
    for arm, way in zip(arms, directions, strict=True):
        kind = "vertical" if abs(way[2]) > 0.8 else "lateral" if abs(way[1]) > 0.98 else ""
        end = "" if abs(arm[0]) < 0.2 * reach[0] or reach[0] < 1e-9 else "front" if arm[0] > 0 else "rear"
        side = (
            "" if abs(arm[1]) < 0.2 * reach[1] or reach[1] < 1e-9 else "starboard" if arm[1] > 0 else "port"
        )
        names.append(" ".join(filter(None, (kind, end, side))) or "middle")
    counts = {name: names.count(name) for name in names}
    seen: dict[str, int] = {}
    for i, name in enumerate(names):
        seen[name] = seen.get(name, 0) + 1
        names[i] = f"{name} {seen[name]}" if counts[name] > 1 else name
    return names


def _own_names(keys: VehicleFile) -> Sequence[str]:
    names = tuple(keys.names or (thruster.name for thruster in keys.thrusters or ()))
    return names if names and all(names) else ()


def _thrusters(names: Sequence[str], positions: FloatArray, directions: FloatArray) -> list[Thruster]:
    return [
        Thruster(position=_three(position), direction=_three(direction), name=name)
        for name, position, direction in zip(names, positions, directions, strict=True)
    ]


def _three(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 4) + 0.0 for value in vector)
    return x, y, z


def _rounded(T: FloatArray) -> list[list[float]]:
    return [[float(f"{value + 0.0:.6g}") for value in row] for row in T.tolist()]


def _finite(values: FloatArray) -> FloatArray:
    return np.where(np.isfinite(values), values, 0.0)
