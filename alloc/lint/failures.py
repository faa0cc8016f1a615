"""Cost of each failure of a single thruster, and the remarks on it."""

from collections.abc import Iterator, Sequence
from math import comb

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import NotApplicable, VehicleError
from alloc.lint.report import Failure, Level, Remark, warning
from alloc.nullspace.allocator import exact
from alloc.reach.attainable import FACETS, alpha_range
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import condition

INVOLVED = 0.3
"""Share of a lost direction's largest coefficient from which an axis is named, with rows of unit length."""


def failures(vehicle: Vehicle) -> list[Failure]:
    """Cost of the loss of each working thruster, one at a time."""
    axes = np.eye(vehicle.k)
    counted = comb(len(vehicle.working), max(vehicle.rank - 1, 0)) <= FACETS  # beyond, it takes minutes
    whole = _ranges(vehicle, axes) if counted else np.zeros(vehicle.k)
    found = []
    for i in vehicle.working.tolist():
        name = vehicle.names[i] if vehicle.names else ""
        try:
            degraded = vehicle.with_fault(i)
        except VehicleError:
            found.append(Failure(i, name, last=True))
            continue
        lost = [
            tuple(axis for axis, c in zip(vehicle.dof, direction, strict=True) if abs(c) >= INVOLVED)
            for direction in lost_directions(degraded, before=vehicle)
        ]
        left = {
            axis: float(after / before)
            for axis, before, after in zip(
                vehicle.dof, whole, _ranges(degraded, axes) if counted else whole, strict=True
            )
            if 0 < before < np.inf
        }
        found.append(Failure(i, name, False, tuple(lost), condition(degraded), left))
    return found


def lost_directions(vehicle: Vehicle, before: Vehicle | None = None) -> FloatArray:
    """(m, k) directions of wrench that no working thruster pushes, each with 1 as its largest entry.

    Coefficients refer to rows of T scaled to unit length. Directions are reduced, so that each has few axes.
    Given the same vehicle ``before`` a failure, directions that it lacked already are left out.
    """
    rows = _unpushed(vehicle)
    if before is not None and before.rank < before.k:
        known = _unpushed(before)
        rows = np.linalg.svd(rows - rows @ known.T @ known)[2][: before.rank - vehicle.rank]
    for i in range(len(rows)):  # row echelon form with the largest pivots
        j = int(np.argmax(np.abs(rows[i])))
        rows[i] /= rows[i, j]
        for other in range(len(rows)):
            if other != i:
                rows[other] -= rows[other, j] * rows[i]
    return rows


def _unpushed(vehicle: Vehicle) -> FloatArray:
    U = np.linalg.svd(vehicle.TP / vehicle.row_lengths[:, None])[0]
    return U[:, vehicle.rank :].T.copy()


def _ranges(vehicle: Vehicle, axes: FloatArray) -> FloatArray:
    low, high = alpha_range(vehicle, axes)
    return np.maximum(high - low, 0.0)


WORSE = 10.0
"""Factor on the condition number by which a failure nearly takes a direction away."""


def on_failures(found: Sequence[Failure], whole: float) -> Iterator[Remark]:
    """Remarks on the loss of one thruster; failures that cost the same share a remark.

    ``whole`` is the condition number before them.
    """
    alike: dict[tuple[Level, str], list[Failure]] = {}
    for failure in found:
        if failure.last or failure.lost:
            costs: tuple[Level, str] = ("warning", failure.words)
        elif failure.condition is not None and failure.condition > WORSE * whole:
            costs = "warning", f"a direction is all but lost (condition {failure.condition:.0f})"
        else:
            costs = "note", failure.words
        alike.setdefault(costs, []).append(failure)
    for (level, words), same in alike.items():
        numbers = "" if any(failure.name for failure in same) else "thruster "
        names = [failure.name or f"{'' if numbers else 'thruster '}{failure.thruster}" for failure in same]
        yield level, "", f"without {numbers}{_either(names)}: {words}"


def on_exact_method(vehicle: Vehicle) -> tuple[int | None, list[Remark]]:
    """Steps of the exact method at worst; None, and a remark, where it does not apply."""
    try:
        return exact(vehicle).worst_case_steps, []
    except NotApplicable as reason:
        return None, [warning("T", str(reason))]


def _either(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
