"""What the arrays of a vehicle must be, each by itself and together."""

from typing import TYPE_CHECKING

import numpy as np

from alloc.allocation import FloatArray, real
from alloc.errors import VehicleError
from alloc.vehicle.frame import checked_frame
from alloc.vehicle.geometry import DOF
from alloc.vehicle.limits import check_slew, check_table
from alloc.vehicle.names import check_names

if TYPE_CHECKING:
    from alloc.vehicle.model import Vehicle

ARRAYS = ("T", "H", "f_min", "f_max", "readiness", "slack_weights")
LARGEST, SMALLEST = 1e15, 1e-9
"""Bounds on the sizes in a vehicle [N, m]; between them no product over- or underflows."""


def checked_array(vehicle: "Vehicle", key: str) -> FloatArray:
    """The numbers of an array as they were given; raises VehicleError where they are none or too large."""
    name = vehicle.name
    try:
        array = real(np.asarray(getattr(vehicle, key)))
    except (TypeError, ValueError, OverflowError) as error:
        raise VehicleError(f"{name}: {key} is not an array of numbers ({error})", key) from None
    if not np.isfinite(array).all():
        raise VehicleError(f"{name}: {key} holds NaN or infinity; every entry must be finite", key)
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise VehicleError(f"{name}: {key} holds a number above {LARGEST:g}; check its unit", key)
    return array


def check_shapes(vehicle: "Vehicle") -> None:
    """Raise VehicleError where an array's shape, DOFs, names or the frame are those of no vehicle."""
    name, dof = vehicle.name, vehicle.dof
    checked_frame(vehicle.frame)
    unknown = [axis for axis in dof if axis not in DOF]
    if unknown or len(set(dof)) != len(dof) or not dof:
        raise VehicleError(f"{name}: dof {list(dof)} must be distinct names out of {list(DOF)}", "dof")
    if vehicle.T.ndim != 2 or vehicle.T.shape[0] != len(dof) or vehicle.T.shape[1] == 0:
        raise VehicleError(f"{name}: T has shape {vehicle.T.shape}; give {len(dof)} rows, one a DOF", "T")
    k, n = vehicle.T.shape
    shapes = {"H": (n, n), "f_min": (n,), "f_max": (n,), "readiness": (n,), "slack_weights": (k,)}
    for key, shape in shapes.items():
        actual = getattr(vehicle, key).shape
        if actual != shape:
            raise VehicleError(
                f"{name}: {key} has shape {actual}; {n} thrusters and {k} DOF need {shape}", key
            )
    check_names(vehicle.names, n)


def check_values(vehicle: "Vehicle") -> None:
    """Raise VehicleError where limits, weights or readiness contradict themselves."""
    name, H = vehicle.name, vehicle.H
    if np.abs(vehicle.T).max() < SMALLEST:
        raise VehicleError(f"{name}: T is all zeros; no thruster pushes any controlled DOF", "T")
    wrong = np.flatnonzero(vehicle.f_min > vehicle.f_max)
    if wrong.size:
        i = int(wrong[0])
        named = f" of {vehicle.called(i)}" if vehicle.names else ""
        raise VehicleError(
            f"{name}: f_min[{i}] = {vehicle.f_min[i]:g} exceeds f_max[{i}] = {vehicle.f_max[i]:g}{named}",
            "f_min",
        )
    if vehicle.f_scale < SMALLEST:
        raise VehicleError(
            f"{name}: f_min and f_max are all 0; give what the thrusters can push [N]", "f_max"
        )
    sizes = np.linalg.eigvalsh(H)
    # Asymmetry is relative to sqrt(H_ii H_jj), the bound of |H_ij|, so that rounding in H passes. An
    # eigenvalue 1e-12 of the largest can't be told from zero in T H^-1 T' because of rounding.
    diagonal = np.sqrt(np.abs(np.diag(H)))
    lopsided = (np.abs(H - H.T) > 1e-12 * np.outer(diagonal, diagonal)).any()
    if lopsided or sizes.min() <= 1e-12 * sizes.max():
        raise VehicleError(f"{name}: H (or weights) must be symmetric positive definite (eq. 4)", "H")
    if ((vehicle.readiness < 0) | (vehicle.readiness > 1)).any():
        raise VehicleError(f"{name}: readiness must lie between 0 (off) and 1 (ready)")
    if not vehicle.readiness.any():
        raise VehicleError(f"{name}: every thruster is off; at least one must work")
    if (vehicle.slack_weights <= 0).any():
        raise VehicleError(f"{name}: slack_weights must be positive", "slack_weights")


def check_parts(vehicle: "Vehicle") -> None:
    """Raise VehicleError where slew rates, limits by voltage or ESCs are those of other thrusters."""
    if vehicle.slew is not None:
        check_slew(vehicle.slew, vehicle.n)
    if vehicle.by_volts is not None:
        check_table(vehicle.by_volts, vehicle.n)
    if vehicle.esc and len(vehicle.esc) != vehicle.n:
        raise VehicleError(f"{vehicle.name}: {len(vehicle.esc)} ESCs for {vehicle.n} thrusters", "esc")
