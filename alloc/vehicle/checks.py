"""Checks of a vehicle's numbers: finite, of one shape, and no contradiction."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray, real
from alloc.errors import VehicleError
from alloc.vehicle.esc import Esc
from alloc.vehicle.geometry import DOF
from alloc.vehicle.limits import Slew, VoltageTable, check_slew, check_table

ARRAYS = ("T", "H", "f_min", "f_max", "readiness", "slack_weights")
LARGEST, SMALLEST = 1e15, 1e-9
"""Bounds on the sizes in a vehicle [N, m]; between them no product over- or underflows."""
SINGULAR = 1e-12
"""Share of the largest eigenvalue of H up to which rounding in T H^-1 T' hides another, as if it were 0."""


def checked_array(name: str, key: str, given: ArrayLike) -> FloatArray:
    """The numbers of an array as they were given; raises VehicleError where they are none or too large."""
    try:
        array = real(np.asarray(given))
    except (TypeError, ValueError, OverflowError) as error:
        raise VehicleError(f"{name}: {key} is not an array of numbers ({error})", key) from None
    if not np.isfinite(array).all():
        raise VehicleError(f"{name}: {key} holds NaN or infinity; every entry must be finite", key)
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise VehicleError(f"{name}: {key} holds a number above {LARGEST:g}; check its unit", key)
    return array


def check_shapes(name: str, dof: Sequence[str], arrays: Mapping[str, FloatArray]) -> None:
    """Raise VehicleError where the DOFs or the shapes of ``ARRAYS`` are those of no vehicle."""
    unknown = [axis for axis in dof if axis not in DOF]
    if unknown or len(set(dof)) != len(dof) or not dof:
        raise VehicleError(f"{name}: dof {list(dof)} must be distinct names out of {list(DOF)}", "dof")
    T = arrays["T"]
    if T.ndim != 2 or T.shape[0] != len(dof) or T.shape[1] == 0:
        raise VehicleError(f"{name}: T has shape {T.shape}; give {len(dof)} rows, one a DOF", "T")
    k, n = T.shape
    shapes = {"H": (n, n), "f_min": (n,), "f_max": (n,), "readiness": (n,), "slack_weights": (k,)}
    for key, shape in (shapes | {"poses": (6, n)}).items():
        if key in arrays and arrays[key].shape != shape:
            raise VehicleError(
                f"{name}: {key} has shape {arrays[key].shape}; {n} thrusters and {k} DOF need {shape}", key
            )


def check_values(name: str, names: Sequence[str], arrays: Mapping[str, FloatArray]) -> None:
    """Raise VehicleError where limits, weights or readiness contradict themselves."""
    T, H, f_min, f_max, readiness, slack_weights = (arrays[key] for key in ARRAYS)
    if np.abs(T).max() < SMALLEST:
        raise VehicleError(f"{name}: T is all zeros; no thruster pushes any controlled DOF", "T")
    wrong = np.flatnonzero(f_min > f_max)
    if wrong.size:
        i = int(wrong[0])
        named = f" of {names[i]}" if names and names[i] else ""
        raise VehicleError(
            f"{name}: f_min[{i}] = {f_min[i]:g} exceeds f_max[{i}] = {f_max[i]:g}{named}", "f_min"
        )
    if max(np.abs(f_min).max(), np.abs(f_max).max()) < SMALLEST:
        raise VehicleError(
            f"{name}: f_min and f_max are all 0; give what the thrusters can push [N]", "f_max"
        )
    sizes = np.linalg.eigvalsh(H)
    # Asymmetry is relative to sqrt(H_ii H_jj), the bound of |H_ij|, so that rounding in H passes.
    diagonal = np.sqrt(np.abs(np.diag(H)))
    lopsided = (np.abs(H - H.T) > 1e-12 * np.outer(diagonal, diagonal)).any()
    if lopsided or sizes.min() <= SINGULAR * sizes.max():
        raise VehicleError(f"{name}: H (or weights) must be symmetric positive definite (eq. 4)", "H")
    if ((readiness < 0) | (readiness > 1)).any():
        raise VehicleError(f"{name}: readiness must lie between 0 (off) and 1 (ready)")
    if not readiness.any():
        raise VehicleError(f"{name}: every thruster is off; at least one must work")
    if (slack_weights <= 0).any():
        raise VehicleError(f"{name}: slack_weights must be positive", "slack_weights")


def check_parts(
    name: str, n: int, slew: Slew | None, by_volts: VoltageTable | None, esc: Sequence[Esc]
) -> None:
    """Raise VehicleError where slew rates, limits by voltage or ESCs are not those of n thrusters."""
    if slew is not None:
        check_slew(slew, n)
    if by_volts is not None:
        check_table(by_volts, n)
    if esc and len(esc) != n:
        raise VehicleError(f"{name}: {len(esc)} ESCs for {n} thrusters", "esc")
