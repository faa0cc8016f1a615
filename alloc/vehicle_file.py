"""Vehicle files: YAML in, ``Vehicle`` out, and back."""

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from alloc.allocation import FloatArray
from alloc.errors import UnknownName, VehicleError
from alloc.geometry import DOF, from_flu, planar_matrix, pose_matrix
from alloc.vehicle import Vehicle

Numbers = list[float]
SLACK_WEIGHT = 2000.0
"""Default diagonal of Q, relative to H = I: the value vortex-auv ships (auv_setup, nautilus.yaml)."""


class Planar(msgspec.Struct, forbid_unknown_fields=True):
    """Thrusters in the horizontal plane, as eq. 3 takes them."""

    alpha_deg: Numbers
    d: Numbers
    phi_deg: Numbers


class Thruster(msgspec.Struct, forbid_unknown_fields=True):
    """One thruster at a pose: position [m], direction (unit vector) [-]."""

    position: tuple[float, float, float]
    direction: tuple[float, float, float]
    name: str = ""


class VehicleFile(msgspec.Struct, forbid_unknown_fields=True):
    """The keys of a vehicle file; exactly one of planar, T and thrusters gives the geometry."""

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
    """A vehicle file as read: the checked keys and the line each top-level key stands on."""

    path: Path
    keys: VehicleFile
    lines: dict[str, int]


def list_vehicles() -> tuple[str, ...]:
    """Names of the shipped vehicles, sorted."""
    folder = resources.files("alloc") / "vehicles"
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def load_vehicle(name: str | Path) -> Vehicle:
    """A shipped vehicle by name, or any vehicle by the path of its YAML file.

    Raises UnknownName if there is neither, VehicleError (file, key, remedy) for what the file says.
    """
    document = read_document(find_file(name))
    try:
        return build_vehicle(document.keys)
    except VehicleError as error:
        raise VehicleError(f"{document.path}: {error}") from None


def find_file(name: str | Path) -> Path:
    """The file behind a shipped name or a path; raises UnknownName."""
    text = str(name)
    if text in list_vehicles():
        return Path(str(resources.files("alloc") / "vehicles" / f"{text}.yaml"))
    path = Path(text)
    if path.suffix in (".yaml", ".yml") or path.exists():
        return path
    raise UnknownName(
        f"no vehicle '{text}'; shipped ones are {', '.join(list_vehicles())}, or give a path to a .yaml file"
    )


def read_document(path: Path) -> Document:
    """Read and check one YAML file; raises VehicleError naming file, line, key and remedy."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise VehicleError(f"{path}: can't be read ({reason}); give a readable YAML file") from None
    yaml = YAML(typ="rt", pure=True)  # YAML 1.2 (1e-5 is a number), no tags run, duplicate keys refused
    try:
        data = yaml.load(text)
    except MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise VehicleError(f"{path}: line {line}: not valid YAML ({error.problem}); mend that line") from None
    except (YAMLError, ValueError, RecursionError) as error:
        raise VehicleError(f"{path}: not valid YAML ({type(error).__name__}); mend the file") from None
    if not isinstance(data, CommentedMap):
        raise VehicleError(f"{path}: holds no keys; start with 'name:', 'dof:' and a geometry")
    lines = {str(key): int(data.lc.key(key)[0]) + 1 for key in data}
    try:
        keys = msgspec.convert(_plain(data), VehicleFile)
    except msgspec.ValidationError as error:
        raise VehicleError(f"{path}: {_explain(str(error), lines)}") from None
    return Document(path, keys, lines)


def build_vehicle(keys: VehicleFile) -> Vehicle:
    """The Vehicle that a file's keys describe; raises VehicleError."""
    rows = [DOF.index(axis) for axis in keys.dof]
    T = _geometry(keys, rows)
    k, n = len(rows), T.shape[1] if T.ndim == 2 else 0
    if keys.weights is not None and keys.H is not None:
        raise VehicleError("weights and H both give the matrix of eq. 4; keep one of them")
    weights = keys.weights if keys.weights is not None else [1.0] * n
    H = np.array(keys.H) if keys.H is not None else np.diag(weights)
    vehicle = Vehicle(
        name=keys.name,
        dof=tuple(keys.dof),
        T=T,
        H=H,
        f_min=_per_thruster(keys.f_min, n),
        f_max=_per_thruster(keys.f_max, n),
        readiness=np.ones(n),
        slack_weights=np.array(keys.slack_weights if keys.slack_weights is not None else [SLACK_WEIGHT] * k),
        source=keys.source,
    )
    meant = keys.rank if keys.rank is not None else k
    if vehicle.rank != meant:
        raise VehicleError(
            f"rank: T has rank {vehicle.rank} but {meant} is asked for; drop a DOF that no thruster "
            f"moves independently from 'dof', or write 'rank: {vehicle.rank}' if that is meant"
        )
    return vehicle


def _geometry(keys: VehicleFile, rows: list[int]) -> FloatArray:
    given = [key for key in ("planar", "T", "thrusters") if getattr(keys, key) is not None]
    if len(given) != 1:
        raise VehicleError(f"geometry: give exactly one of planar, T and thrusters (found {given or 'none'})")
    if keys.T is not None:
        return _rectangular("T", keys.T)
    if keys.planar is not None:
        p = keys.planar
        if not len(p.alpha_deg) == len(p.d) == len(p.phi_deg):
            raise VehicleError("planar: alpha_deg, d and phi_deg must be equally long, one entry a thruster")
        full = planar_matrix(np.array(p.alpha_deg), np.array(p.d), np.array(p.phi_deg))
        planar_rows = {0: 0, 1: 1, 5: 2}
        if not set(rows) <= set(planar_rows):
            raise VehicleError("dof: planar thrusters move surge, sway and yaw only; name no others")
        return full[[planar_rows[row] for row in rows]]
    thrusters = keys.thrusters or []
    if not thrusters:
        raise VehicleError("thrusters: the list is empty; give one entry a thruster")
    positions = np.array([t.position for t in thrusters])
    directions = np.array([t.direction for t in thrusters])
    center = np.array(keys.center_of_mass)
    if keys.frame == "flu":
        positions, directions, center = from_flu(positions), from_flu(directions), from_flu(center)
    lengths = np.linalg.norm(directions, axis=1)
    if (np.abs(lengths - 1) > 1e-3).any():  # published unit vectors carry three digits or more
        i = int(np.argmax(np.abs(lengths - 1)))
        raise VehicleError(f"thrusters[{i}].direction has length {lengths[i]:.4g}; give a unit vector")
    return pose_matrix(positions, directions, center)[rows]


def _rectangular(key: str, rows: list[Numbers]) -> FloatArray:
    if len({len(row) for row in rows}) != 1:
        raise VehicleError(f"{key}: rows differ in length; give one entry a thruster in every row")
    return np.array(rows, dtype=float)


def _per_thruster(value: float | Numbers, n: int) -> FloatArray:
    return np.full(n, value) if isinstance(value, (int, float)) else np.array(value, dtype=float)


def _plain(data: Any) -> Any:
    # ruamel's round-trip containers and scalars carry comments and lines; msgspec wants builtins.
    if isinstance(data, dict):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_plain(value) for value in data]
    for builtin in (bool, int, float, str):
        if isinstance(data, builtin):
            return builtin(data)
    return data


def _explain(message: str, lines: dict[str, int]) -> str:
    # msgspec writes "… - at `$.f_min[2]`"; put the line of the key in front.
    what, _, where = message.partition(" - at `$")
    key = where.rstrip("`").lstrip(".")
    top = key.split(".")[0].split("[")[0]
    if not top and "unknown field" in what:
        top = key = what.split("`")[1]
    place = f"line {lines[top]}: " if top in lines else ""
    return f"{place}{key + ': ' if key else ''}{what}; see a shipped vehicle file for the form"
