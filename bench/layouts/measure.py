"""Figures of many layouts at once: the columns of a shard, and the study's constraints."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc import NotApplicable, Vehicle, build
from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.nullspace.allocator import STEPS_LIMIT
from alloc.nullspace.region import Regions, nearest_many, steps_bound
from alloc.vehicle.geometry import DOF, unit
from bench.judging.loss import FLOOR
from bench.layouts.authority import (
    closed_form_volumes,
    reach,
    safe_shares,
    unannounced_shares,
    volumes,
    worst_faults,
)
from bench.layouts.space import LayoutSpace, PlacedThrusters, poses
from bench.layouts.spaces import Layouts, Spaces, spaces, subsets
from bench.layouts.study import Constraints, Wake
from bench.record import SERVED_WITHIN

CALLS_AT_ONCE = 8192
"""Layouts times demands that are worked on at once: their arrays stay in the processor's cache."""

SLACK = 1e-9
"""Excess over a limit that counts as met, relative to the largest limit, as in the exact method."""


class Shares(NamedTuple):
    """Shares of demands served (B,), and the mean effort f'Hf of the thrusts that serve them.

    Attributes
    ----------
    closed_form, exact : share of the demands [-]
    closed_form_effort, exact_effort : mean over the demands that are served, NaN without any [N^2 for H = I]
    """

    closed_form: FloatArray
    exact: FloatArray
    closed_form_effort: FloatArray
    exact_effort: FloatArray


def shares(layouts: Layouts, found: Spaces, taus: FloatArray) -> Shares:
    """Shares of the demands (N, k) that each layout serves.

    The closed form's thrusts T* tau are clipped to the limits; a demand is served where what they push errs
    by at most SERVED_WITHIN, lengths in the layout's own ``wrench_scale``. The exact method serves what is
    attainable.
    """
    step = max(CALLS_AT_ONCE // max(len(taus), 1), 1)
    parts = []
    for first in range(0, len(layouts), step):
        part = slice(first, first + step)
        spaces = found.G[..., part], found.N[..., part], found.dependencies[..., part]
        parts.append(_shares(layouts.take(part), *spaces, taus))
    return Shares(*(np.concatenate(numbers) for numbers in zip(*parts, strict=True)))


def _shares(layouts: Layouts, G: FloatArray, N: FloatArray, y: FloatArray, taus: FloatArray) -> Shares:
    k, n, count = layouts.T.shape
    demands = len(taus)
    F = (G.transpose(0, 2, 1).reshape(n * count, k) @ taus.T).reshape(n, count, demands)
    lower, upper = layouts.f_min[..., None] - F, layouts.f_max[..., None] - F
    excess = np.minimum(np.maximum(lower, 0.0), upper)  # what clipping adds to each thrust
    scale = layouts.wrench_scale
    miss = np.matmul((layouts.T / scale[:, None]).transpose(2, 0, 1), excess.transpose(1, 0, 2))
    size = (1.0 / scale.T**2) @ (taus.T**2)
    by_form = (miss**2).sum(axis=1) <= SERVED_WITHIN**2 * np.maximum(size, FLOOR**2)
    weights = layouts.weights[..., None]
    effort = (F**2 * weights).sum(axis=0)
    clipped = ((F + excess) ** 2 * weights).sum(axis=0)
    inside = (excess == 0.0).all(axis=0)
    asked = np.flatnonzero(~inside)
    slack = SLACK * np.maximum(-layouts.f_min, layouts.f_max).max(axis=0)
    of = np.arange(count).repeat(demands)[asked]
    low, high = lower.reshape(n, -1).take(asked, axis=1), upper.reshape(n, -1).take(asked, axis=1)
    attainable = inside
    if steps_bound(n, n - k) <= STEPS_LIMIT:
        z, excess_left = nearest_many(Regions(N, slack), low, high, of)
        attainable.reshape(-1)[asked] = excess_left <= 1.0
        effort.reshape(-1)[asked] += (z**2).sum(axis=0)
    else:  # the exact method does not take such a layout, so it has no effort
        attainable.reshape(-1)[asked] = _inside_facets(y, low, high, slack, of)
        effort[:] = np.nan
    return Shares(
        by_form.mean(axis=1), attainable.mean(axis=1), _mean(clipped, by_form), _mean(effort, attainable)
    )


def _inside_facets(
    y: FloatArray, lower: FloatArray, upper: FloatArray, slack: FloatArray, layout: IndexArray
) -> BoolArray:
    """Mask of calls with some z, lower <= N z <= upper: for no y with y N = 0 do limits exclude y N z = 0."""
    n, size = len(lower), y.shape[1]
    met = np.ones(len(layout), dtype=bool)
    for rows, facet in zip(subsets(n, size), y, strict=True):
        least, largest, room = np.zeros(len(layout)), np.zeros(len(layout)), np.zeros(len(layout))
        for row, of_layout in zip(rows, facet, strict=True):
            weight = of_layout[layout]
            ends = weight * lower[row], weight * upper[row]
            least += np.minimum(*ends)
            largest += np.maximum(*ends)
            room += np.abs(weight) * slack[layout]
        met &= (least <= room) & (largest >= -room)
    return met


def _mean(values: FloatArray, chosen: BoolArray) -> FloatArray:
    count = chosen.sum(axis=1)
    means: FloatArray = np.where(chosen, values, 0.0).sum(axis=1) / np.where(count, count, np.nan)
    return means


def refused(poses: PlacedThrusters, constraints: Constraints) -> dict[str, BoolArray]:
    """For each constraint, by its key in the file, which layouts (B,) break it."""
    position = poses.position
    broken: dict[str, BoolArray] = {}
    for axis, ends in enumerate((constraints.box.x, constraints.box.y, constraints.box.z)):
        if ends is not None:
            least, largest = position[:, axis].min(axis=0), position[:, axis].max(axis=0)
            broken[f"box.{'xyz'[axis]}"] = (least < ends[0] - ROUNDING) | (largest > ends[1] + ROUNDING)
    first, second = np.triu_indices(len(position), 1)
    if constraints.distance > 0:
        apart = np.sqrt(((position[first] - position[second]) ** 2).sum(axis=1))
        broken["distance"] = (apart < constraints.distance - ROUNDING).any(axis=0)
    if constraints.wake is not None:
        broken["wake"] = _in_a_wake(poses, constraints.wake)
    return broken


ROUNDING = 1e-12
"""Metres that do not count: an end of the box is inside."""


def _in_a_wake(poses: PlacedThrusters, wake: Wake) -> BoolArray:
    """True if a thruster sits in another one's jet, which leaves against the thrust, also in reverse."""
    n, _, count = poses.position.shape
    hit = np.zeros(count, dtype=bool)
    widening = np.tan(np.radians(wake.spread_deg))
    for i in range(n):
        to = np.delete(poses.position, i, axis=0) - poses.position[i]
        along = (to * poses.direction[i]).sum(axis=1)
        aside = np.sqrt(np.maximum((to**2).sum(axis=1) - along**2, 0.0))
        ahead, astern = poses.f_min[i] < 0, poses.f_max[i] > 0
        downstream = np.where(along > 0, ahead, astern) & (np.abs(along) <= wake.length)
        hit |= (downstream & (aside < wake.radius + np.abs(along) * widening)).any(axis=0)
    return hit


AT_ONCE = 512
"""Layouts that are worked on at once: few enough that their arrays stay in the processor's cache."""

Columns = dict[str, NDArray[np.float64] | NDArray[np.int64]]


class Measurements(NamedTuple):
    """The numbers of layouts, and how many have none.

    Attributes
    ----------
    columns : by name, one entry for each layout that keeps to the constraints and has full rank
    places : (M,) which of the layouts those are
    refused : by constraint, or ``rank``, how many layouts break it first
    """

    columns: Columns
    places: NDArray[np.int64]
    refused: dict[str, int]


def measure(space: LayoutSpace, values: FloatArray) -> Measurements:
    """The numbers of the layouts with parameters ``values`` (P, B)."""
    parts: list[Columns] = []
    kept: list[NDArray[np.int64]] = []
    reasons: dict[str, int] = {}
    for group in poses(space, values):
        left = np.ones(len(group.which), dtype=bool)
        for reason, broken in refused(group, space.constraints).items():
            reasons[reason] = reasons.get(reason, 0) + int((left & broken).sum())
            left &= ~broken
        layouts = group.layouts(space.dof).take(left)
        places = group.which[left]
        for first in range(0, len(layouts), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            full, columns = numbers(layouts.take(part), space.dof, space.taus, space.scale, space.volume)
            reasons["rank"] = reasons.get("rank", 0) + int((~full).sum())
            parts.append(columns)
            kept.append(places[part][full])
    names = column_names(space.dof)
    if not parts:
        return Measurements({name: np.zeros(0) for name in names}, np.zeros(0, dtype=np.int64), reasons)
    which = np.concatenate(kept)
    order = np.argsort(which, kind="stable")
    columns = {name: np.concatenate([part[name] for part in parts])[order] for name in names}
    return Measurements(columns, which[order], {reason: count for reason, count in reasons.items() if count})


def numbers(
    layouts: Layouts, dof: tuple[str, ...], taus: FloatArray, scale: FloatArray, volume: float
) -> tuple[NDArray[np.bool_], Columns]:
    """Mask of layouts of full rank (B,), and the columns of those; authority 1 means ``volume``."""
    full, found = spaces(layouts)
    layouts = layouts.take(full)
    n, count = layouts.weights.shape
    if not count:
        return full, {name: np.zeros(0) for name in column_names(dof)}
    sizes = volumes(layouts, found)
    one, two = worst_faults(layouts, found, sizes)
    far = reach(layouts, found, scale)
    served = shares(layouts, found, taus)
    none = np.full(count, np.nan)
    pair = subsets(n, 2)[two.which].T if two is not None else np.full((2, count), -1)
    columns: Columns = {
        "thrusters": np.full(count, n),
        "nullity": np.full(count, found.d),
        "worst_case_steps": _steps(layouts, found),
        "authority": sizes.whole / volume,
        "authority_after_one": one.volume / volume,
        "authority_after_two": two.volume / volume if two is not None else np.zeros(count),
        "worst_thruster": one.which,
        "worst_pair_a": pair[0],
        "worst_pair_b": pair[1],
        "rank_after_one": one.rank,
        "rank_after_two": two.rank if two is not None else np.zeros(count, dtype=np.int64),
        "condition": found.sigma[0] / found.sigma[-1],
        "condition_after_one": one.condition,
        "condition_after_two": two.condition if two is not None else none,
        "any_direction_N": far.any_direction,
        "unannounced_share": unannounced_shares(layouts, found, scale),
        "safe_share": safe_shares(layouts, found),
        "closed_form_volume_share": closed_form_volumes(layouts, found) / sizes.whole,
        "closed_form_served_share": served.closed_form,
        "exact_served_share": served.exact,
        "closed_form_effort_N2": served.closed_form_effort,
        "exact_effort_N2": served.exact_effort,
    }
    for row, axis in enumerate(dof):
        columns[f"{axis}_min_{_unit(axis)}"] = far.axis_min[row]
        columns[f"{axis}_max_{_unit(axis)}"] = far.axis_max[row]
    return full, columns


NUMBERS = {
    "thrusters": int,
    "nullity": int,
    "worst_case_steps": float,
    "authority": float,
    "authority_after_one": float,
    "authority_after_two": float,
    "worst_thruster": int,
    "worst_pair_a": int,
    "worst_pair_b": int,
    "rank_after_one": int,
    "rank_after_two": int,
    "condition": float,
    "condition_after_one": float,
    "condition_after_two": float,
    "any_direction_N": float,
    "unannounced_share": float,
    "safe_share": float,
    "closed_form_volume_share": float,
    "closed_form_served_share": float,
    "exact_served_share": float,
    "closed_form_effort_N2": float,
    "exact_effort_N2": float,
}
"""Columns of every study, and their kinds; the largest wrenches along each axis follow them."""


def column_names(dof: tuple[str, ...]) -> tuple[str, ...]:
    """The names of all columns of numbers, in order."""
    axes = (f"{axis}_{end}_{_unit(axis)}" for axis in dof for end in ("min", "max"))
    return (*NUMBERS, *axes)


def _unit(axis: str) -> str:
    return unit(axis).replace(" ", "")


def _steps(layouts: Layouts, found: Spaces) -> FloatArray:
    """Worst-case steps of the exact method (B,), NaN where it does not take the layout.

    They depend on which thrusters the null space ties together, and so on which minors of its basis are zero:
    of all layouts with the same zeros, one is asked.
    """
    zeros = np.packbits(np.abs(found.minors) > 1e-9 * np.abs(found.minors).max(axis=0), axis=0)
    _, first, of = np.unique(zeros, axis=1, return_index=True, return_inverse=True)
    return np.array([_steps_of(layouts.take(slice(i, i + 1))) for i in first])[of.ravel()]


def _steps_of(layout: Layouts) -> float:
    k, n, _ = layout.T.shape
    vehicle = Vehicle(
        name="layout",
        dof=DOF[:k],
        T=layout.T[..., 0],
        H=np.diag(layout.weights[:, 0]),
        f_min=layout.f_min[:, 0],
        f_max=layout.f_max[:, 0],
        readiness=np.ones(n),
        slack_weights=np.ones(k),
    )
    try:
        allocate = build("nullspace", vehicle)
    except NotApplicable:
        return float("nan")
    return float(getattr(allocate, "worst_case_steps", np.nan))
