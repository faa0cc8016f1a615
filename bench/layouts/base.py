"""The base of a study: its thrusters' poses, and the vehicle of the degrees of freedom that count."""

from dataclasses import dataclass

import numpy as np

from alloc import Vehicle, list_vehicles
from alloc.allocation import FloatArray
from alloc.errors import FileError, UnknownName, VehicleError, unknown
from alloc.vehicle.file import matrices, vehicle_with
from alloc.vehicle.geometry import DOF, pose_matrix
from alloc.vehicle.keys import VehicleFile
from alloc.vehicle.poses import Mounting, poses
from alloc.vehicle.read import find_file, read_document
from bench.layouts.study import StudyDocument

LEFT_OUT = ("slack_weights", "slew", "volts", "esc", "priority", "groups")


@dataclass(frozen=True, eq=False)
class Base:
    """A vehicle, and where its thrusters stand, in its frame.

    Attributes
    ----------
    vehicle : T from the poses, in the degrees of freedom that count
    position, direction : (n, 3) [m], [-]
    center : (3,) of mass [m]
    left_out : keys of its file that no layout has: a new thruster has no slew rate, and another size no curve
    """

    vehicle: Vehicle
    position: FloatArray
    direction: FloatArray
    center: FloatArray
    left_out: tuple[str, ...]


def read_base(document: StudyDocument) -> Base:
    """The base that a study names; raises StudyError where it is none to vary."""
    name = document.keys.base
    path = find_file(name) if name in list_vehicles() else document.tree.path.parent / name
    try:
        if name not in list_vehicles() and not path.exists():
            raise unknown("vehicle", name, list_vehicles(), ", or a file beside the study")
        file = read_document(path).keys
        stands = _poses(file)
        position, center = stands.positions, stands.center
        direction = stands.directions / np.linalg.norm(stands.directions, axis=1, keepdims=True)
        dof = tuple(document.keys.dof if document.keys.dof is not None else file.dof)
        if not dof or not set(dof) <= set(DOF) or len(set(dof)) < len(dof):
            raise document.refusal("dof", f"give different names out of {', '.join(DOF)}")
        T = pose_matrix(position, direction, center)[[DOF.index(axis) for axis in dof]]
        vehicle = vehicle_with(_counted(file, dof), T)
        _check(vehicle)
    except (VehicleError, UnknownName, FileError) as error:
        raise document.refusal("base", str(error)) from None
    left_out = tuple(key for key in LEFT_OUT if getattr(file, key))
    return Base(vehicle, position, direction, center, left_out)


def _counted(file: VehicleFile, dof: tuple[str, ...]) -> VehicleFile:
    from msgspec.structs import replace

    kept = None
    if file.slack_weights is not None:
        by_axis: dict[str, float] = dict(zip(file.dof, file.slack_weights, strict=False))
        kept = [by_axis[axis] for axis in dof] if set(dof) <= set(by_axis) else None
    return replace(file, dof=list(dof), slack_weights=kept, rank=None)


def _poses(file: VehicleFile) -> Mounting:
    """Where the thrusters stand; raises VehicleError for a file that has T alone, which does not say."""
    found = poses(file, matrices(file)[0])
    if file.reaction_torque:
        raise VehicleError(
            f"{file.name} has propellers' own moments, which layouts leave out; study it without them",
            "reaction_torque",
        )
    if not found.measured:
        raise VehicleError(
            f"{file.name} has T, but no poses that could vary; give it 'thrusters' or 'planar' too", "T"
        )
    return found


def _check(vehicle: Vehicle) -> None:
    """Raise VehicleError for a base whose layouts could not be compared."""
    name = vehicle.name
    if vehicle.rank < vehicle.k:
        raise VehicleError(
            f"{name} pushes {vehicle.rank} of {vehicle.k} degrees of freedom alone; name those under 'dof'"
        )
    if (vehicle.f_min > 0).any() or (vehicle.f_max < 0).any() or (vehicle.f_min >= vehicle.f_max).any():
        raise VehicleError(f"{name} has a thruster that can't rest or can't push; give f_min <= 0 <= f_max")
    if np.count_nonzero(vehicle.H - np.diag(np.diag(vehicle.H))):
        raise VehicleError(f"{name} has an H that couples thrusters; layouts take 'weights', one a thruster")
