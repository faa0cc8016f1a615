"""Vehicle files: YAML in, ``Vehicle`` out."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import UnknownName, VehicleError
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle import Vehicle
from alloc.vehicle.geometry import DOF, contradictions, from_flu, planar_matrix, pose_matrix

Numbers = list[float]
SLACK_WEIGHT = 2000.0
"""Default diagonal of Q, relative to H = I: the value vortex-auv ships (auv_setup, nautilus.yaml)."""

LONGEST_NAME = 60
"""A name stands in tables, messages and file names."""


class Planar(msgspec.Struct, forbid_unknown_fields=True):
    """Thrusters in the horizontal plane, as eq. 3 takes them."""

    alpha_deg: Numbers
    d: Numbers
    phi_deg: Numbers


class Thruster(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """One thruster at a pose: position [m], direction (unit vector) [-]."""

    position: tuple[float, float, float]
    direction: tuple[float, float, float]
    name: str = ""


class VehicleFile(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The keys of a vehicle file. T or poses (planar, thrusters) give the geometry; both must then agree."""

    name: str
    dof: list[Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]]
    f_min: float | Numbers
    f_max: float | Numbers
    source: str = ""
    planar: Planar | None = None
    T: list[Numbers] | None = None
    thrusters: list[Thruster] | None = None
    frame: Literal["frd", "flu"] = "frd"
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0)
    weights: Numbers | None = None
    H: list[Numbers] | None = None
    slack_weights: Numbers | None = None
    rank: int | None = None
    notes: list[str] = []


@dataclass(frozen=True)
class Document:
    """A vehicle file as read: the checked keys, and the tree that knows each one's line."""

    keys: VehicleFile
    tree: YamlTree

    def located(self, error: VehicleError) -> VehicleError:
        """The same error with file and line in front."""
        line = self.tree.lines.get(error.key)
        place = f"{self.tree.path}: line {line}" if line else str(self.tree.path)
        return VehicleError(f"{place}: {error}", error.key)


def list_vehicles() -> tuple[str, ...]:
    """Names of the shipped vehicles, sorted."""
    folder = resources.files("alloc") / "vehicles"
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def load_vehicle(name: str | Path) -> Vehicle:
    """A shipped vehicle by name, or any vehicle by the path of its YAML file.

    Raises UnknownName if there is neither, FileError for what is no readable YAML, VehicleError
    (file, line, key, remedy) for what the file says.
    """
    document = read_document(find_file(name))
    try:
        return build_vehicle(document.keys)
    except VehicleError as error:
        raise document.located(error) from None


def find_file(name: str | Path) -> Path:
    """The file behind a shipped name or a path; raises UnknownName."""
    text = str(name)
    if text in list_vehicles():
        return Path(str(resources.files("alloc") / "vehicles" / f"{text}.yaml"))
    path = Path(text)
    if path.suffix in (".yaml", ".yml") or "/" in text or _exists(path):
        return path
    raise UnknownName(
        f"no vehicle '{text}'; shipped ones are {', '.join(list_vehicles())}, or give a path to a .yaml file"
    )


def read_document(path: Path) -> Document:
    """Read one vehicle file and check its form; raises FileError or VehicleError."""
    tree = read_yaml(path)
    if not isinstance(tree.data, dict):
        raise VehicleError(f"{path}: holds no keys; start with 'name:', 'dof:' and a geometry")
    try:
        return Document(msgspec.convert(tree.data, VehicleFile), tree)
    except msgspec.ValidationError as error:
        raise VehicleError(f"{path}: {_explain(str(error), tree)}") from None


def build_vehicle(keys: VehicleFile) -> Vehicle:
    """The Vehicle that a file's keys describe; raises VehicleError."""
    T, computed = matrices(keys)
    if computed is not None:
        for contradiction in contradictions(T, computed, keys.dof):
            raise VehicleError(f"T: {contradiction}; correct the one that is wrong, or leave it out", "T")
    vehicle = vehicle_with(keys, T)
    meant = keys.rank if keys.rank is not None else vehicle.k
    if vehicle.rank != meant:
        raise VehicleError(
            f"rank: T has rank {vehicle.rank} but {meant} is asked for; drop a DOF that no thruster "
            f"moves independently from 'dof', or write 'rank: {vehicle.rank}' if that is meant",
            "rank",
        )
    return vehicle


def matrices(keys: VehicleFile) -> tuple[FloatArray, FloatArray | None]:
    """T (k, n), z down; and, where the file gives poses beside a T, the T that those make."""
    if keys.planar is not None and keys.thrusters is not None:
        raise VehicleError("planar and thrusters both give poses; keep one of them", "planar")
    found = []
    if keys.T is not None:
        found.append(_rectangular("T", keys.T))
        if len(keys.T) != len(keys.dof):
            raise VehicleError(f"T: has {len(keys.T)} rows; give {len(keys.dof)}, one a DOF in 'dof'", "T")
    if keys.planar is not None:
        found.append(_planar(keys.planar, keys.dof))
    if keys.thrusters is not None:
        found.append(_posed(keys.thrusters, keys.center_of_mass, keys.dof))
    if keys.frame == "flu":
        found = [from_flu(T, keys.dof) for T in found]
    match found:
        case []:
            raise VehicleError("no geometry; give thrusters, planar or T")
        case [T]:
            return T, None
        case [T, computed] if T.shape == computed.shape:
            return T, computed
    raise VehicleError(
        f"T: has {found[0].shape[1]} columns, but the poses are of {found[1].shape[1]} thrusters", "T"
    )


def vehicle_with(keys: VehicleFile, T: FloatArray) -> Vehicle:
    """The Vehicle of a file's keys with this T (k, n), whatever its rank; raises VehicleError."""
    k, n = T.shape
    if not 0 < len(keys.name) <= LONGEST_NAME or not keys.name.isprintable() or "/" in keys.name:
        raise VehicleError(f"name: give 1 to {LONGEST_NAME} printable characters without '/'", "name")
    if keys.weights is not None and keys.H is not None:
        raise VehicleError("weights and H both give the matrix of eq. 4; keep one of them", "H")
    if keys.weights is not None and len(keys.weights) != n:
        raise VehicleError(
            f"weights: {len(keys.weights)} numbers for {n} thrusters; give one each", "weights"
        )
    H = np.diag(keys.weights or [1.0] * n) if keys.H is None else _rectangular("H", keys.H)
    return Vehicle(
        name=keys.name,
        dof=tuple(keys.dof),
        T=T,
        H=H,
        f_min=_per_thruster(keys.f_min, n),
        f_max=_per_thruster(keys.f_max, n),
        readiness=np.ones(n),
        slack_weights=np.array([SLACK_WEIGHT] * k if keys.slack_weights is None else keys.slack_weights),
        source=keys.source,
    )


def _planar(planar: Planar, dof: Sequence[str]) -> FloatArray:
    if not len(planar.alpha_deg) == len(planar.d) == len(planar.phi_deg) > 0:
        raise VehicleError(
            "planar: alpha_deg, d and phi_deg must be equally long, one entry a thruster", "planar"
        )
    rows = {"surge": 0, "sway": 1, "yaw": 2}
    beyond = [axis for axis in dof if axis not in rows]
    if beyond:
        raise VehicleError(f"dof: planar thrusters move surge, sway and yaw only, not {beyond[0]}", "dof")
    T = planar_matrix(np.array(planar.alpha_deg), np.array(planar.d), np.array(planar.phi_deg))
    return T[[rows[axis] for axis in dof]]


def _posed(thrusters: list[Thruster], center: tuple[float, float, float], dof: Sequence[str]) -> FloatArray:
    if not thrusters:
        raise VehicleError("thrusters: the list is empty; give one entry a thruster", "thrusters")
    directions = np.array([t.direction for t in thrusters])
    lengths = np.linalg.norm(directions, axis=1)
    i = int(np.argmax(np.abs(lengths - 1)))
    if abs(lengths[i] - 1) > 1e-3:  # published unit vectors carry three digits or more
        key = f"thrusters[{i}].direction"
        unit = directions[i] / lengths[i] if 0 < lengths[i] < np.inf else np.eye(3)[0]
        entries = ", ".join(f"{entry:.4g}" for entry in unit)
        raise VehicleError(f"{key} has length {lengths[i]:.4g}; give a unit vector, as [{entries}]", key)
    T = pose_matrix(np.array([t.position for t in thrusters]), directions, np.array(center))
    return T[[DOF.index(axis) for axis in dof]]


def _rectangular(key: str, rows: list[Numbers]) -> FloatArray:
    if len({len(row) for row in rows}) != 1 or not rows[0]:
        raise VehicleError(
            f"{key}: rows differ in length or are empty; give one entry a thruster in each", key
        )
    return np.array(rows, dtype=np.float64)


def _per_thruster(value: float | Numbers, n: int) -> FloatArray:
    return np.full(n, value, dtype=np.float64) if isinstance(value, (int, float)) else np.array(value)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # too long for a file name, or holding a zero byte
        return False


def _explain(message: str, tree: YamlTree) -> str:
    # msgspec writes "… - at `$.f_min[2]`"; put the line of that entry in front.
    what, _, where = message.partition(" - at `$")
    key = where.rstrip("`").lstrip(".")
    if "unknown field" in what:
        key = f"{key}.{what.split('`')[1]}".lstrip(".")
    line = tree.line(key) if key else None
    said = f"{key}: {what}" if key else what
    short = "".join(c if c.isprintable() else " " for c in said)[:90]  # a key may be any text
    return f"{f'line {line}: ' if line else ''}{short}; {_remedy(what, key)}"


def _remedy(what: str, key: str) -> str:
    place = key.partition("[")[0].partition(".")[0]
    if "field" in what:
        keys = {"planar": Planar, "thrusters": Thruster}.get(place, VehicleFile).__struct_fields__
        return f"the keys are {', '.join(keys)}"
    if "enum" in what:
        return f"give one of {', '.join(DOF if place == 'dof' else ('frd', 'flu'))}"
    return "docs/your-vehicle.md shows the form"
