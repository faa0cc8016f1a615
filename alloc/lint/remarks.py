"""The remarks on a vehicle: what its file contradicts, what looks like a slip, what follows from it."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import NotApplicable
from alloc.lint.digits import decimals, nearly_dependent
from alloc.lint.failures import Failure, lost_directions
from alloc.lint.report import Level
from alloc.nullspace.allocator import exact
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.columns import alike, refusals
from alloc.vehicle.condition import condition, wrench_doubt
from alloc.vehicle.file import called, reaction_torques, suspects
from alloc.vehicle.geometry import MOMENTS, contradictions
from alloc.vehicle.keys import VehicleFile
from alloc.vehicle.read import find_file, list_vehicles

CONDITION = 20.0
"""Condition number, with rows of unit length, above which a direction is nearly lost: a push in the weakest
direction then takes 20 times the thrust of one in the strongest. Published vehicles lie below 4."""
WORSE = 10.0
"""Factor on the condition number by which a failure nearly takes a direction away."""
FARTHEST_ARM = 100.0  # m; a longer arm is probably written in mm
SHORTEST_ARM = 2e-3  # m; where no arm is longer, they are probably written in km or the vehicle is a toy
NORMALISED = 1.0
"""Largest limit [N] that looks like a share of full throttle, or like kilonewtons: the weakest thrusters sold
for underwater vehicles give some 5 N."""
STRONGEST = 1e7  # N; ten times the thrust of a large ship's bow thruster, so probably mN
WIDEST_WEIGHTS = 1e4  # a wider spread costs an iterative solver half of its digits

Remark = tuple[Level, str, str]
"""Level, key of the file that the remark is about, and message."""


def on_name(keys: VehicleFile, path: Path) -> Iterator[Remark]:
    """A remark on a file that has the name of a shipped vehicle, and is another file."""
    if keys.name in list_vehicles() and not path.samefile(find_file(keys.name)):
        yield (
            "note",
            "name",
            f"{keys.name} is a shipped vehicle, too; with another name tables tell them apart",
        )


def on_poses(
    keys: VehicleFile, present: set[str], T: FloatArray, computed: FloatArray | None
) -> Iterator[Remark]:
    """Remarks on frame and poses, and on T (k, n) against the T ``computed`` from the poses.

    ``present`` holds the keys that stand in the file.
    """
    if computed is not None:
        for contradiction in contradictions(T, computed, keys.dof, called(keys, T.shape[1])):
            yield "error", "T", f"{contradiction}; correct the one that is wrong, or leave it out"
    if "frame" not in present:
        yield "note", "frame", "no 'frame' given; x forward, y starboard, z down (frd) is taken for granted"
    if keys.thrusters is None:
        if "center_of_mass" in present:
            yield (
                "warning",
                "center_of_mass",
                "has no effect without thrusters; put it into T, or leave it out",
            )
        return
    positions = np.array([thruster.position for thruster in keys.thrusters])
    middle = positions.mean(axis=0)
    reach = np.linalg.norm(positions - middle, axis=1).max()
    if "center_of_mass" not in present:
        yield "note", "center_of_mass", "not given; moments are taken about the origin of the positions"
    elif np.linalg.norm(np.array(keys.center_of_mass) - middle) > reach:
        yield "warning", "center_of_mass", "lies outside the thrusters; check its unit (m) and its origin"
    if np.abs(positions).max() > FARTHEST_ARM:
        yield "warning", "thrusters", f"a position is over {FARTHEST_ARM:g} m off; mm? divide by 1000"
    names = called(keys, len(keys.thrusters))
    for i, thruster in enumerate(keys.thrusters):
        for j, other in enumerate(keys.thrusters[:i]):
            if (other.position, other.direction) == (thruster.position, thruster.direction):
                yield (
                    "warning",
                    f"thrusters[{i}]",
                    f"{names[i]} has the same position and direction as {names[j]}",
                )
                break


def on_mirror_images(keys: VehicleFile) -> Iterator[Remark]:
    """A remark on each pair, port and starboard, that points against its mirror image where others don't.

    Pairs that push straight to a side say nothing: people have them point the same way or apart.
    """
    if keys.thrusters is None:
        return
    positions = np.array([thruster.position for thruster in keys.thrusters])
    directions = np.array([thruster.direction for thruster in keys.thrusters])
    mirror = np.array([1.0, -1.0, 1.0])
    middle = np.array([0.0, keys.center_of_mass[1], 0.0])
    near = 0.02 * np.ptp(positions, axis=0).max() + 1e-9
    alike, against = [], []
    for i in range(len(positions)):
        image = (positions[i] - middle) * mirror + middle
        for j in np.flatnonzero(np.linalg.norm(positions - image, axis=1) <= near).tolist():
            if j <= i or np.abs(directions[i] * mirror).dot([1.0, 0.0, 1.0]) < 0.05:
                continue
            if np.allclose(directions[j], directions[i] * mirror, atol=0.02):
                alike.append((i, j))
            elif np.allclose(directions[j], -directions[i] * mirror, atol=0.02):
                against.append((i, j))
    if len(alike) > len(against):
        for i, j in against:
            a, b = (keys.thrusters[at].name or f"thruster {at}" for at in (i, j))
            yield (
                "warning",
                f"thrusters[{j}]",
                f"{a} and {b} are mirror images that push opposite ways, unlike {len(alike)} other"
                f" {'pair' if len(alike) == 1 else 'pairs'}; is one reversed?",
            )


def on_columns(keys: VehicleFile, T: FloatArray) -> Iterator[Remark]:
    """Remarks on columns of T (k, n) that no thruster can make, and on moments that propellers explain."""
    n = T.shape[1]
    moments = reaction_torques(keys, n)
    published, names = suspects(keys, n), called(keys, n)
    refused = refusals(T, keys.dof, moments, names)
    for i, refusal in refused.items():
        if i in published:
            yield "warning", "suspect", f"taken as published: {refusal}"
        else:
            yield "error", "T", f"{refusal}; to take it as published, write 'suspect: [{i}]'"
    for i in sorted(published - refused.keys()):
        yield "warning", "suspect", f"{names[i]} is a thrust along a line; leave it out"
    if not moments.any() and (typical := alike(T, keys.dof)):
        yield (
            "warning",
            "T",
            f"every thruster has a moment of {typical:.2g} m along its own thrust, as propellers of one kind"
            " make; if it is theirs, 'reaction_torque' says so",
        )


def on_reach(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on directions that no thruster pushes or nearly none, and on thrusters that push nothing."""
    meant = vehicle.k if keys.rank is None else keys.rank
    if vehicle.rank != meant:
        missing = (
            f" (no thruster pushes {'; none '.join(unreachable(vehicle))})" if vehicle.rank < meant else ""
        )
        yield (
            "error",
            "rank",
            f"T has rank {vehicle.rank} but {meant} is asked for{missing}; leave out of 'dof' what no"
            f" thruster moves independently, or write 'rank: {vehicle.rank}' if that is meant",
        )
    else:
        for direction in unreachable(vehicle):
            yield "warning", "T", f"no thruster pushes {direction}"
    if (c := condition(vehicle)) > CONDITION:
        yield (
            "warning",
            "T",
            f"close to losing a direction: condition number {c:.2g}, above {CONDITION:g}. The weakest takes "
            f"{c:.2g} times the thrust of the strongest, and rounding alone moves thrusts by up to "
            f"{wrench_doubt(vehicle):.1g} of the largest limit",
        )
    strongest = np.abs(vehicle.T / vehicle.row_lengths[:, None]).max(axis=0)
    for i in np.flatnonzero(strongest <= RANK_TOLERANCE):  # 0, or rounding such as cos 90 deg
        name = vehicle.called(int(i))
        yield "warning", "T", f"{name} moves no controlled DOF; leave it out, or name the DOF it moves"


def on_digits(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on a printed T whose last digits decide which thrusters depend on each other."""
    if keys.T is None or (digits := decimals(vehicle.T)) is None:
        return
    near, count = nearly_dependent(vehicle, digits)
    if near:
        yield (
            "note",
            "T",
            f"looks like a symmetric vehicle printed to {digits} decimals: {near} of {count} sets of"
            f" {vehicle.rank} thrusters depend on each other but for the last digit; poses ('thrusters') give"
            " it exactly",
        )


def on_limits(vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on limits that are one-sided, uneven, equal or look assumed."""
    low, high = vehicle.f_min, vehicle.f_max
    for i in np.flatnonzero((low > 0) | (high < 0)):
        yield (
            "warning",
            "f_min" if low[i] > 0 else "f_max",
            f"{vehicle.called(int(i))} can't stop: 0 N is outside its limits",
        )
    for i in np.flatnonzero(low == high):
        name = vehicle.called(int(i))
        yield "warning", "f_max", f"{name} has f_min = f_max = {low[i]:g} N; it can't be commanded"
    one_way = np.flatnonzero(((low == 0) | (high == 0)) & (low != high))
    if one_way.size:
        yield "note", "f_min", f"{one_way.size} of {vehicle.n} thrusters push one way only"
    uneven = np.flatnonzero((low < 0) & (high > 0) & (low != -high))
    if uneven.size:
        first = int(uneven[0])
        span = f"{low[first]:g} … {high[first]:g} N"
        yield "note", "f_max", f"not the same ahead and astern ({span}): mind which way each one points"
    sizes = np.concatenate([np.abs(low), np.abs(high)])
    if len(set(sizes[sizes > 0])) == 1 and _round(sizes.max()):
        yield (
            "note",
            "f_max",
            f"{sizes.max():g} N for every thruster is a round number; measured, or assumed?",
        )


def on_units(vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on limits and arms that can't be newtons and metres, with the factor that they are off by."""
    if vehicle.f_scale <= NORMALISED:
        yield (
            "warning",
            "f_max",
            f"no thruster gives more than {vehicle.f_scale:g} N: a share of full throttle, as PX4 has it, or"
            " kN? multiply f_min and f_max by full thrust in N (kN: by 1000)",
        )
    if vehicle.f_scale > STRONGEST:
        yield "warning", "f_max", f"{vehicle.f_scale:g} N is more than any thruster gives; mN? divide by 1000"
    rows = [row for axis, row in zip(vehicle.dof, vehicle.T, strict=True) if axis in MOMENTS]
    arms = np.abs(rows)
    if not arms.size or not arms.any():
        return
    if arms.max() > FARTHEST_ARM:
        yield "warning", "T", f"an arm is {arms.max():g} m long; mm? divide the moment rows by 1000"
    if arms.max() < SHORTEST_ARM:
        yield "warning", "T", f"the longest arm is {arms.max():g} m; km? multiply the moment rows by 1000"


def on_moving_limits(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """Remarks on what the lowest voltage leaves, and on how long full thrust takes by the slew rates."""
    whence = "esc" if keys.volts is None else "volts"
    if (table := vehicle.by_volts) is not None:
        lowest = float(table.volts[0])
        low, high = vehicle.limits(volts=lowest)
        weakest = int(np.argmin(high - low))
        yield (
            "note",
            whence,
            f"at {lowest:g} V {vehicle.called(weakest)} gives {low[weakest]:g} … {high[weakest]:g} N"
            f" of {vehicle.f_min[weakest]:g} … {vehicle.f_max[weakest]:g} N",
        )
        for i in np.flatnonzero(table.f_max.max(axis=0) < vehicle.f_max):
            yield (
                "warning",
                "f_max",
                f"{vehicle.called(int(i))} gives {table.f_max[:, i].max():g} N at most by '{whence}', less"
                f" than f_max = {vehicle.f_max[i]:g} N",
            )
    if vehicle.slew is not None:
        slowest = float((vehicle.f_max / vehicle.slew.up).max())
        yield "note", "slew", f"from 0 N to f_max the slowest thruster takes {slowest:.2g} s"


def on_weights(vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on an H that is spread too widely for iterative solvers."""
    spread = np.linalg.cond(vehicle.H)
    if spread > WIDEST_WEIGHTS:
        yield (
            "warning",
            "weights",
            f"differ by a factor of {spread:.0e}; iterative solvers lose digits over that",
        )


def on_failures(found: Sequence[Failure], whole: float) -> Iterator[Remark]:
    """What each loss of one thruster costs; failures that cost the same share a remark.

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
        return None, [("warning", "T", str(reason))]


def unreachable(vehicle: Vehicle) -> list[str]:
    """The directions of wrench that no working thruster pushes, in words: ``pitch``, ``roll - 0.2 sway``.

    There is one direction for each lost rank. Coefficients refer to rows of T scaled to unit length.
    """
    words = []
    for direction in lost_directions(vehicle):
        terms = [
            f"{'-' if c < 0 else '+'} {'' if abs(abs(c) - 1) < 5e-3 else f'{abs(c):.2g} '}{axis}"
            for c, axis in zip(direction, vehicle.dof, strict=True)
            if abs(c) > 0.01
        ]
        words.append(" ".join(terms).removeprefix("+ "))
    return words


def _either(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"


def _round(value: float) -> bool:
    # Round numbers have one digit and zeros, as 40, 200 or 1.
    return float(f"{value:.0e}") == value
