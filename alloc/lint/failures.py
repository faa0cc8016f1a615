"""Cost of each failure of one thruster or two, directions weak or counted in part, and remarks on them."""

from collections.abc import Iterator, Sequence
from itertools import chain, combinations
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import NotApplicable, VehicleError
from alloc.formulations import mixed
from alloc.lint.report import Failure, Level, Pairs, Remark, percent, together, warning
from alloc.nullspace.allocator import exact
from alloc.reach.attainable import FACETS, alpha_range
from alloc.reach.zonotope import candidates
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import condition
from alloc.vehicle.pieces import combinations as convex_vehicles

INVOLVED = 0.3
"""Share of a lost direction's largest coefficient from which an axis is named, with rows of unit length."""


def failures(vehicle: Vehicle) -> list[Failure]:
    """Cost of the loss of each working thruster, one at a time."""
    axes = np.eye(vehicle.k)
    counted = candidates(vehicle) <= FACETS  # beyond, it takes minutes
    whole = _ranges(vehicle, axes) if counted else np.zeros(vehicle.k)
    found = []
    for i in vehicle.ready:
        name = vehicle.names[i] if vehicle.names else ""
        try:
            degraded = vehicle.with_fault(i)
        except VehicleError:
            found.append(Failure(i, name, last=True))
            continue
        if len(degraded.weak) == degraded.k:
            found.append(Failure(i, name, last=True))
            continue
        lost = _lost(degraded, vehicle)
        left = {
            axis: float(after / before)
            for axis, before, after in zip(
                vehicle.dof, whole, _ranges(degraded, axes) if counted else whole, strict=True
            )
            if 0 < before < np.inf
        }
        weak = _weak_left(degraded, vehicle)
        part = in_part(degraded, vehicle)
        found.append(Failure(i, name, False, lost, condition(degraded.strong), left, weak, part))
    return found


NEW = 0.5
"""Part of a weak direction that must lie outside of those that were weak before, if a failure made it."""
FEWEST_LEFT = 2
"""Thrusters that must be left for a pair of failures to be looked at."""
RIGHTED = ("heave", "roll", "pitch")
"""Axes whose loss sinks or rolls a vehicle: such pairs come first."""


def pairs(vehicle: Vehicle) -> list[Pairs]:
    """Pairs of thrusters whose loss takes more than that of one; those that sink or roll first."""
    found: dict[tuple[object, ...], Pairs] = {}
    on = vehicle.ready
    states = {i: vehicle.with_fault(i) for i in on} if len(on) >= 2 + FEWEST_LEFT else {}
    alone = {i: (_lost(state, vehicle), in_part(state, vehicle).keys()) for i, state in states.items()}
    for i, j in combinations(states, 2):
        degraded = states[i].with_fault(j)
        lost, part = _lost(degraded, vehicle), in_part(degraded, vehicle)
        if (lost, part.keys()) in (((), {}.keys()), alone[i], alone[j]):
            continue
        weak = _weak_left(degraded, vehicle)
        key = lost, weak > 0.0, *part
        one = found.get(key, Pairs((), lost, weak, part))
        names = (*one.names, (vehicle.called(i), vehicle.called(j)))
        least = {axes: min(counts, part[axes]) for axes, counts in one.in_part.items()}
        found[key] = Pairs(names, lost, max(weak, one.weak), least)
    return sorted(found.values(), key=lambda pair: -sum(axis in RIGHTED for axis in chain(*pair.lost)))


def _lost(degraded: Vehicle, before: Vehicle) -> tuple[tuple[str, ...], ...]:
    """Directions that a failure takes, each by the axes that it couples; none where every one is weak."""
    if len(degraded.weak) == degraded.k:
        return ()
    rows = lost_directions(degraded.strong, before=before.strong)
    return tuple(_axes(degraded, direction) for direction in rows)


def _weak_left(degraded: Vehicle, before: Vehicle) -> float:
    """Largest sigma / sigma_max of the directions that a failure makes weak [-]."""
    scale = degraded.directions.scale
    now, known = degraded.weak * scale, before.weak * scale  # orthonormal
    new = np.linalg.norm(now - now @ known.T @ known, axis=1) > NEW
    return float(degraded.weak_left[new].max(initial=0.0))


def in_part(degraded: Vehicle, before: Vehicle) -> dict[str, float]:
    """Share to which each direction counts that a failure makes count in part, by its axes [-]."""
    scale = degraded.directions.scale
    known = before.directions.rows[before.counts < 1.0] * scale  # orthonormal
    found = {}
    for each in weak_axes(degraded):
        along = each.row * scale
        if each.counts and np.linalg.norm(along - along @ known.T @ known) > NEW:
            found[together(each.axes)] = each.counts
    return found


def _axes(vehicle: Vehicle, direction: FloatArray) -> tuple[str, ...]:
    return tuple(axis for axis, c in zip(vehicle.dof, direction, strict=True) if abs(c) >= INVOLVED)


class WeakAxis(NamedTuple):
    """A direction that is pushed, and weak or counted in part.

    Attributes
    ----------
    row : (k,) c, so that c'tau is the part of a wrench along it
    axes : those that it couples
    authority : sigma / sigma_max [-]
    counts : share to which methods with a share count it, 0 where it is weak [-]
    """

    row: FloatArray
    axes: tuple[str, ...]
    authority: float
    counts: float

    @property
    def words(self) -> str:
        """``pitch (0.5 % left)``, ``pitch (1.3 % left, counts by 40 %)``."""
        part = f", counts by {percent(self.counts)} %" if self.counts else ""
        return f"{' and '.join(self.axes)} ({percent(self.authority)} % left{part})"


def weak_axes(vehicle: Vehicle) -> list[WeakAxis]:
    """Directions that are pushed, and weak or counted in part, from the one with the most authority on."""
    of, found = vehicle.directions, []
    for i in np.flatnonzero(vehicle.counts[: vehicle.rank] < 1.0).tolist():
        sizes = of.rows[i] * of.scale
        axes = _axes(vehicle, sizes / np.abs(sizes).max())
        authority, counts = float(of.sigma[i] / of.sigma[0]), float(vehicle.counts[i])
        found.append(WeakAxis(of.rows[i], axes, authority, counts))
    return found


def on_weak(vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on each direction of the whole vehicle that is weak or counts in part: who does what."""
    of = vehicle.directions
    best = vehicle.dof[int(np.argmax(np.abs(of.rows[0] * of.scale)))]
    for each in weak_axes(vehicle):
        if vehicle.weak_limit is not None:
            than = f"'weak: {vehicle.weak_limit:g}' asks for"
        else:
            than = f"a survey of {vehicle.survey.words} can make"
        less, do = f"less than {than}", "leave it out"
        if each.counts:
            less, do = f"{1.0 + each.counts:.2g} times what {than}", f"count it by {percent(each.counts)} %"
        yield warning(
            "weak",
            f"{' and '.join(each.axes)}: {percent(each.authority)} % of {best}, {less}; scaled and priority"
            f" {do}; nullspace and the QPs hold it at zero with all the thrust that takes, or refuse, and"
            " clip misses the rest: leave it out of 'dof', or survey finer",
        )


def lost_directions(vehicle: Vehicle, before: Vehicle | None = None) -> FloatArray:
    """(m, k) directions of wrench that no working thruster pushes, each with 1 as its largest entry.

    Coefficients refer to rows of T scaled to unit length. Directions are reduced, so that each has few axes.
    Given the same vehicle ``before`` a failure, directions that it lacked already are left out.
    """
    rows = _unpushed(vehicle)
    if before is not None and before.rank < before.k:
        known = _unpushed(before)
        rows = np.linalg.svd(rows - rows @ known.T @ known)[2][: max(before.rank - vehicle.rank, 0)]
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
    """Range (k,) of each axis, mixed as answers are where a direction counts in part."""
    ranges = []
    for _, strong in vehicle.mixture:
        asked = axes
        if strong is not vehicle:  # of an axis what is left of it without weak directions
            U = np.linalg.svd(strong.TP / strong.row_lengths[:, None])[0][:, : strong.rank]
            left = axes / strong.row_lengths @ U @ U.T * strong.row_lengths
            asked = np.where(np.diag(left)[:, None] >= KEPT, left, axes)
        low, high = alpha_range(strong, asked)
        ranges.append(np.maximum(high - low, 0.0))
    return mixed(ranges, [w for w, _ in vehicle.mixture])


KEPT = 0.5
"""Share of an axis that must be left beside weak directions for its range to be given."""
WORSE = 10.0
"""Factor on the condition number by which a failure nearly takes a direction away."""


def on_failures(found: Sequence[Failure], whole: float) -> Iterator[Remark]:
    """Remarks on the loss of one thruster; failures that cost the same share a remark.

    ``whole`` is the condition number before them.
    """
    alike: dict[tuple[Level, str], list[Failure]] = {}
    for failure in found:
        if failure.last or failure.lost or failure.in_part:
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
    """Most steps of the exact method, of all its problems; None, and a remark, where it does not apply."""
    try:
        return sum(exact(one).worst_case_steps for one in convex_vehicles(vehicle)), []
    except NotApplicable as reason:
        return None, [warning("T", str(reason))]


def _either(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
