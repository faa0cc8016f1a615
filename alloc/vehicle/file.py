"""Vehicle files: found by name or path, read, and made vehicles."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.errors import VehicleError, unknown
from alloc.files.keys import convert
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle import Vehicle
from alloc.vehicle.autopilot import make_autopilot, mixer_frame, thrust_by_curve
from alloc.vehicle.azimuth import refuse_azimuths
from alloc.vehicle.azimuth_file import check_directions, expand
from alloc.vehicle.checks import SINGULAR
from alloc.vehicle.current_file import read_cap, with_currents
from alloc.vehicle.esc_file import LARGEST_COMMAND, curve_limits, escs, voltage_table, with_curve_read
from alloc.vehicle.geometry import DOF, contradictions, planar_matrix, pose_matrix, possible, refusals
from alloc.vehicle.keys import EscKeys, InertiaKeys, Numbers, Planar, Rates, SurveyKeys, VehicleFile
from alloc.vehicle.limits import Slew, VoltageTable
from alloc.vehicle.names import listed
from alloc.vehicle.weak import ALL_WEAK, DRAWN, Survey

SLACK_WEIGHT = 2000.0
"""Default diagonal of Q, relative to H = I: the value vortex-auv ships (auv_setup, nautilus.yaml)."""

LONGEST_NAME = 60
"""Most characters of a name, since it stands in tables, messages and file names."""


def build_vehicle(keys: VehicleFile) -> Vehicle:
    """The Vehicle that a file's keys describe; raises VehicleError."""
    (keys, azimuths), names = expand(keys), _names(keys)
    T, computed = matrices(keys)
    if computed is not None:
        for contradiction in contradictions(T, computed, keys.dof, called(keys, T.shape[1])):
            raise VehicleError(f"T: {contradiction}; correct the one that is wrong, or leave it out", "T")
    vehicle = vehicle_with(keys, T)
    published, known = suspects(keys, vehicle.n), called(keys, vehicle.n)
    for i, refusal in refusals(T, keys.dof, reaction_torques(keys, vehicle.n), known).items():
        if i not in published:
            raise VehicleError(f"T: {refusal}; to take it as published, write 'suspect: [{i}]'", "T")
    meant = keys.rank if keys.rank is not None else vehicle.k
    if vehicle.rank != meant:
        raise VehicleError(
            f"rank: T has rank {vehicle.rank} but {meant} is asked for; drop a DOF that no thruster "
            f"moves independently from 'dof', or write 'rank: {vehicle.rank}' if that is meant",
            "rank",
        )
    if len(vehicle.weak) == vehicle.k:
        key = "survey" if keys.weak == "auto" else "weak"
        raise VehicleError(f"{key}: {ALL_WEAK}", key)
    return replace(vehicle, azimuths=azimuths, names=names) if azimuths else vehicle


def matrices(keys: VehicleFile) -> tuple[FloatArray, FloatArray | None]:
    """T (k, n); and the T that the poses make where the file gives T and poses, else None."""
    if keys.planar is not None and keys.thrusters is not None:
        raise VehicleError("planar and thrusters both give poses; keep one of them", "planar")
    geometries, rows = [], [DOF.index(axis) for axis in keys.dof]
    if keys.T is not None:
        geometries.append(_rectangular("T", keys.T))
        if len(keys.T) != len(keys.dof):
            raise VehicleError(f"T: has {len(keys.T)} rows; give {len(keys.dof)}, one a DOF in 'dof'", "T")
    if (whole := _of_poses(keys)) is not None:
        geometries.append(whole[rows])
    match geometries:
        case []:
            raise VehicleError("no geometry; give thrusters, planar or T")
        case [T]:
            return T, None
        case [T, computed] if T.shape == computed.shape:
            return T, computed
    raise VehicleError(
        f"T: has {geometries[0].shape[1]} columns, but the poses are of {geometries[1].shape[1]} thrusters",
        "T",
    )


def reaction_torques(keys: VehicleFile, n: int) -> FloatArray:
    """(n,) each propeller's moment along its own thrust [m]; raises VehicleError unless there are n."""
    moments = _per_thruster(keys.reaction_torque or 0.0, n)
    if moments.shape != (n,):
        raise VehicleError(
            f"reaction_torque: {len(moments)} numbers for {n} thrusters; give one each", "reaction_torque"
        )
    return moments


def suspects(keys: VehicleFile, n: int) -> set[int]:
    """The thrusters whose columns are taken as published; raises VehicleError for one that is not there."""
    return listed(keys.suspect, called(keys, n), n, "suspect", "suspect")


def called(keys: VehicleFile, n: int) -> list[str]:
    """Names of the n thrusters of a file, or ``thruster 4``."""
    names = list(keys.names or (thruster.name for thruster in keys.thrusters or ()))
    return [(names[i] if i < len(names) else "") or f"thruster {i}" for i in range(n)]


def vehicle_with(keys: VehicleFile, T: FloatArray) -> Vehicle:
    """The Vehicle of a file's keys with T (k, n) of any rank; raises VehicleError."""
    k, n = T.shape
    if not 0 < len(keys.name) <= LONGEST_NAME or not keys.name.isprintable() or "/" in keys.name:
        raise VehicleError(f"name: give 1 to {LONGEST_NAME} printable characters without '/'", "name")
    if keys.weights is not None and keys.H is not None:
        raise VehicleError("weights and H both give the matrix of eq. 4; keep one of them", "H")
    if keys.weights is not None and len(keys.weights) != n:
        raise VehicleError(
            f"weights: {len(keys.weights)} numbers for {n} thrusters; give one each", "weights"
        )
    if any(not weight > 0 for weight in keys.weights or ()):
        raise VehicleError("weights: give numbers above 0, so that each thrust has a price", "weights")
    if keys.weights and min(keys.weights) <= SINGULAR * max(keys.weights):
        raise VehicleError(
            f"weights: {min(keys.weights):g} is as good as 0 beside {max(keys.weights):g}; give numbers"
            " nearer to each other",
            "weights",
        )
    H = np.diag(keys.weights or [1.0] * n) if keys.H is None else _rectangular("H", keys.H)
    names = _names(keys)
    f_min, f_max = (_said(keys, key, n) for key in ("f_min", "f_max"))
    made = () if keys.esc is None else with_currents(escs(keys.esc, n, names, f_min, f_max), keys.esc)
    if f_min is None or f_max is None:
        low, high = curve_limits(made)
        f_min, f_max = low if f_min is None else f_min, high if f_max is None else f_max
    by_volts = voltage_table(made) if keys.volts is None and made else None
    whole = _of_poses(keys)
    vehicle = Vehicle(
        name=keys.name,
        dof=tuple(keys.dof),
        T=T,
        poses=whole if whole is not None and whole.shape[1] == n else None,
        H=H,
        f_min=f_min,
        f_max=f_max,
        readiness=np.ones(n),
        slack_weights=np.array([SLACK_WEIGHT] * k if keys.slack_weights is None else keys.slack_weights),
        source=keys.source,
        slew=None if keys.slew is None else _slew(keys.slew, n),
        by_volts=by_volts if keys.volts is None else _by_volts(keys.volts, n),
        priority=tuple(map(tuple, keys.priority)),
        groups=tuple(map(tuple, keys.groups)),
        survey=DRAWN if keys.survey is None else _survey(keys.survey),
        weak_limit=None if keys.weak == "auto" else float(keys.weak),
        names=names,
        frame=keys.frame or "frd",
        esc=made,
        inertia=None if keys.inertia is None else _inertia(keys.inertia),
        cap=None if keys.cap is None else read_cap(keys.cap, keys.name, made, f_min, f_max),
    )
    if (said := keys.autopilot) is None:
        return vehicle
    limits = vehicle.f_min, vehicle.f_max
    frame = mixer_frame(said.ardusub, said.px4)
    factors = said.motors, said.reversed, said.coupling, said.gains
    mixer = make_autopilot(frame, limits, names, *factors, said.airmode)
    return replace(vehicle, autopilot=replace(mixer, curve=thrust_by_curve(mixer, said.thrust, bool(made))))


def _inertia(keys: InertiaKeys) -> FloatArray:
    if not keys.mass > 0 or not all(moment > 0 for moment in keys.moments):
        raise VehicleError("inertia: mass and moments must be above 0 [kg, kg m^2]", "inertia")
    if not all(added >= 0 for added in keys.added):
        raise VehicleError("inertia: added: give numbers of 0 or more [kg, kg m^2]", "inertia")
    return np.add([*[keys.mass] * 3, *keys.moments], keys.added)


def _said(keys: VehicleFile, key: str, n: int) -> FloatArray | None:
    """A limit (n,) [N] as the file says it; None where it leaves that to the curves of ``esc``."""
    limit = getattr(keys, key)
    if limit is None and keys.esc is None:
        raise VehicleError(f"{key}: missing; give [N] of the thrusters, or a curve in 'esc'", key)
    return None if limit is None else _per_thruster(limit, n)


def _names(keys: VehicleFile) -> tuple[str, ...]:
    of_poses = tuple(thruster.name for thruster in keys.thrusters or ())
    if keys.names is None:
        return of_poses if any(of_poses) else ()
    if any(of_poses):
        raise VehicleError("names: 'thrusters' names them already; keep one of the two", "names")
    return tuple(keys.names)


def _survey(keys: SurveyKeys) -> Survey:
    given = {key: value for key in ("mm", "deg", "relative") if (value := getattr(keys, key)) is not None}
    if "relative" in given and len(given) > 1:
        raise VehicleError("survey: mm and deg are of poses, relative of T; give one of the two", "survey")
    return Survey(**given)


def _slew(slew: float | Numbers | Rates, n: int) -> Slew:
    rates = slew if isinstance(slew, Rates) else Rates(slew, slew)
    return Slew(_per_thruster(rates.up, n), _per_thruster(rates.down, n))


def _by_volts(table: dict[str, tuple[float | Numbers, float | Numbers]], n: int) -> VoltageTable:
    volts = []
    for text in table:
        try:
            volts.append(float(text))
        except ValueError:
            volts.append(np.nan)
        if not 0 < volts[-1] < LARGEST_COMMAND:
            raise VehicleError(f"volts: {text[:40]!r} is no voltage; give a number of volts", "volts")
    sides = [[_per_thruster(limits[side], n) for limits in table.values()] for side in (0, 1)]
    if any(limit.shape != (n,) for side in sides for limit in side):
        raise VehicleError(f"volts: give one limit for all, or one for each of {n} thrusters", "volts")
    return VoltageTable(np.array(volts), np.array(sides[0]), np.array(sides[1]))


def _from_planar(planar: Planar, dof: Sequence[str]) -> FloatArray:
    if not len(planar.alpha_deg) == len(planar.d) == len(planar.phi_deg) > 0:
        raise VehicleError(
            "planar: alpha_deg, d and phi_deg must be equally long, one entry a thruster", "planar"
        )
    rows = {"surge": 0, "sway": 1, "yaw": 5}
    unmoved = [axis for axis in dof if axis not in rows]
    if unmoved:
        raise VehicleError(f"dof: planar thrusters move surge, sway and yaw only, not {unmoved[0]}", "dof")
    whole = np.zeros((6, len(planar.d)))
    whole[[*rows.values()]] = planar_matrix(planar.alpha_deg, planar.d, planar.phi_deg)
    return whole


def _from_poses(keys: VehicleFile) -> FloatArray:
    thrusters = keys.thrusters
    if not thrusters:
        raise VehicleError("thrusters: the list is empty; give one entry a thruster", "thrusters")
    check_directions(thrusters)
    directions = np.array([t.direction for t in thrusters])
    positions = np.array([t.position for t in thrusters])
    moments = reaction_torques(keys, len(thrusters))
    return pose_matrix(positions, directions, np.array(keys.center_of_mass), moments)


def _of_poses(keys: VehicleFile) -> FloatArray | None:
    """(6, n) all rows that the poses of a file make; None where it has none."""
    if keys.planar is None and keys.thrusters is None:
        return None
    return _from_poses(keys) if keys.planar is None else _from_planar(keys.planar, keys.dof)


def _rectangular(key: str, rows: list[Numbers]) -> FloatArray:
    if len({len(row) for row in rows}) != 1 or not rows[0]:
        raise VehicleError(
            f"{key}: rows differ in length or are empty; give one entry a thruster in each", key
        )
    return np.array(rows, dtype=np.float64)


def _per_thruster(value: float | Numbers, n: int) -> FloatArray:
    return np.full(n, value, dtype=np.float64) if isinstance(value, (int, float)) else np.array(value)


class Mounting(NamedTuple):
    """Mounting of n thrusters, in the frame of their vehicle.

    Attributes
    ----------
    positions : (n, 3) from the origin of the file [m]
    directions : (n, 3) along which positive thrust pushes the vehicle; shorter than 1 where T leaves out a
        part of it, 0 for a thruster that gives no force [-]
    center : (3,) the centre of mass [m]
    measured : whether the file gives positions; else they are the nearest to the centre of mass of all that
        make the same T
    stands : (n,) whether there is such a line of thrust; else position and direction say nothing
    """

    positions: FloatArray
    directions: FloatArray
    center: FloatArray
    measured: bool
    stands: BoolArray


def poses(keys: VehicleFile, T: FloatArray) -> Mounting:
    """The poses of a file's thrusters, with T (k, n) as ``matrices`` makes it of the same file.

    A T without poses tells the line along which a thruster pushes, not where on that line it sits: of
    force e and moment m, the point of the line that is nearest to the centre of mass is e x m / |e|^2.
    """
    all_stand = np.ones(T.shape[1], dtype=bool)
    if keys.thrusters:
        positions = np.array([thruster.position for thruster in keys.thrusters])
        directions = np.array([thruster.direction for thruster in keys.thrusters])
        return Mounting(positions, directions, np.array(keys.center_of_mass), True, all_stand)
    if keys.planar is not None:
        alpha, phi = np.radians(keys.planar.alpha_deg), np.radians(keys.planar.phi_deg)
        zero = np.zeros(len(alpha))
        positions = np.array(keys.planar.d) * np.array([np.cos(phi), np.sin(phi), zero])
        directions = np.array([np.cos(alpha), np.sin(alpha), zero])
        return Mounting(positions.T, directions.T, np.zeros(3), True, all_stand)
    whole = np.zeros((6, T.shape[1]))
    whole[[DOF.index(axis) for axis in keys.dof]] = T
    force, moment = whole[:3].T, whole[3:].T
    squared = (force**2).sum(axis=1, keepdims=True)
    nearest = np.cross(force, moment) / np.where(squared > 0, squared, 1.0)
    stands = possible(T, keys.dof, reaction_torques(keys, T.shape[1])) & (squared[:, 0] > 0)
    return Mounting(nearest, force, np.zeros(3), False, stands)


@dataclass(frozen=True)
class Document:
    """A vehicle file as read.

    Attributes
    ----------
    keys : the checked keys
    tree : the YAML, with the line of each key
    """

    keys: VehicleFile
    tree: YamlTree

    def located(self, error: VehicleError) -> VehicleError:
        """``error`` with file and line in front of its message."""
        return VehicleError(error.what, error.key, path=self.tree.path, line=self.tree.lines.get(error.key))


def list_vehicles(*, azimuths: bool = False) -> tuple[str, ...]:
    """Names of the shipped vehicles, sorted: those of fixed thrusters, or with ``azimuths`` the others."""
    folder = resources.files("alloc") / "vehicles" / ("azimuth" if azimuths else "")
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def load_vehicle(name: str | Path) -> Vehicle:
    """A shipped vehicle by name, or any vehicle by the path of its YAML file.

    Raises UnknownName if there is neither, FileError where the file is no readable YAML, and VehicleError
    (file, line, key, remedy) where its content describes no vehicle.
    """
    document = read_document(find_file(name))
    try:
        return build_document(document, name)
    except VehicleError as error:
        raise document.located(error) from None


def build_document(document: Document, name: str | Path) -> Vehicle:
    """The Vehicle of a file as read, whose azimuths know places by its ``name``; raises VehicleError."""
    vehicle, lines = build_vehicle(document.keys), document.tree.lines
    if not vehicle.azimuths:
        return vehicle
    places = [str(VehicleError(a.place, path=Path(name), line=lines.get(a.place))) for a in vehicle.azimuths]
    placed = [replace(a, place=place) for a, place in zip(vehicle.azimuths, places, strict=True)]
    return replace(vehicle, azimuths=tuple(placed))


def load_fixed_vehicle(name: str | Path) -> Vehicle:
    """A vehicle as ``load_vehicle`` finds it, for what takes none whose thrusters turn.

    Raises NotApplicable where one does, else as ``load_vehicle``.
    """
    vehicle = load_vehicle(name)
    refuse_azimuths(vehicle.azimuths, "this command", "it knows limits that are boxes")
    return vehicle


def find_file(name: str | Path) -> Path:
    """The file behind a shipped name or a path; raises UnknownName."""
    text = str(name)
    for folder, azimuths in (("", False), ("azimuth", True)):
        if text in list_vehicles(azimuths=azimuths):
            return Path(str(resources.files("alloc") / "vehicles" / folder / f"{text}.yaml"))
    path = Path(text)
    if path.suffix in (".yaml", ".yml") or "/" in text or _exists(path):
        return path
    raise unknown(
        "vehicle",
        text,
        [*list_vehicles(), *list_vehicles(azimuths=True)],
        "; or give the path of a .yaml file",
    )


def read_document(path: Path) -> Document:
    """Read one vehicle file and check its form; raises FileError or VehicleError."""
    tree = read_yaml(path)
    if not isinstance(tree.data, dict):
        raise VehicleError("holds no keys; start with 'name:', 'dof:' and a geometry", path=path)
    keys = convert(tree, VehicleFile, "docs/your-vehicle.md", VehicleError)
    if isinstance(keys.esc, EscKeys):
        keys.esc = with_curve_read(keys.esc, path.parent)
    elif keys.esc is not None:
        keys.esc = [with_curve_read(one, path.parent) for one in keys.esc]
    return Document(keys, tree)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # the name is too long for a file, or holds a zero byte
        return False
