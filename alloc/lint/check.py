"""What a vehicle file says about its vehicle, checked: errors, warnings, and what is worth knowing."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import FileError, NotApplicable, VehicleError
from alloc.nullspace.allocator import exact
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.file import VehicleFile, find_file, matrices, read_document, vehicle_with
from alloc.vehicle.geometry import contradictions

CONDITION = 20.0
"""Published vehicles lie below 4, with rows of unit length; at 20, a push in the weakest direction takes
20 times the thrust of one in the strongest."""
WORSE = 10.0
"""A failure that makes the condition number this much worse all but takes a direction away."""
FARTHEST_ARM = 100.0  # m; a longer arm was probably meant in mm
WIDEST_WEIGHTS = 1e4  # beyond it half the digits of an iterative solver go into the scaling


class Finding(NamedTuple):
    """One remark: how bad, on which key, what, and what to do about it.

    An *error* makes the file unusable, a *warning* deserves a second look, a *note* states what was
    taken for granted or what follows.
    """

    level: Literal["error", "warning", "note"]
    key: str
    line: int | None
    message: str


class Facts(NamedTuple):
    """What follows from a usable file; ``condition`` with rows of T scaled to unit length."""

    name: str
    k: int
    n: int
    rank: int
    nullity: int
    condition: float
    worst_case_steps: int | None


@dataclass(frozen=True)
class Report:
    """All that was found in one file; ``facts`` is None where T, H or the limits are unusable."""

    path: Path
    facts: Facts | None
    findings: tuple[Finding, ...]

    def count(self, level: str) -> int:
        """How many findings of that level."""
        return sum(finding.level == level for finding in self.findings)


Remarks = Iterator[tuple[Literal["error", "warning", "note"], str, str]]


def check_vehicle(name: str | Path) -> Report:
    """Check a vehicle file as far as it can be understood; raises UnknownName where there is none."""
    path = find_file(name)
    try:
        document = read_document(path)
    except (FileError, VehicleError) as error:
        return Report(path, None, (_unread(path, error),))
    keys, lines = document.keys, document.tree.lines
    remarks = []
    facts = None
    try:
        T, computed = matrices(keys)
        remarks += [*_poses(keys, set(lines), T, computed)]
        vehicle = vehicle_with(keys, T)
        remarks += [*_reach(keys, vehicle), *_limits(keys, vehicle), *_weights(vehicle)]
        remarks += [*_failures(vehicle), *_exact(vehicle)]
        facts = _facts(vehicle)
    except VehicleError as error:
        remarks.append(("error", error.key, str(error)))
    findings = [Finding(level, key, lines.get(key), text) for level, key, text in remarks]
    findings.sort(key=lambda finding: ("error", "warning", "note").index(finding.level))
    return Report(path, facts, tuple(findings))


def _unread(path: Path, error: FileError | VehicleError) -> Finding:
    # The message of a reader starts with the file and mostly with the line.
    text = str(error).removeprefix(f"{path}: ")
    line = re.match(r"line (\d+): ", text)
    key = getattr(error, "key", "")
    return Finding("error", key, int(line[1]) if line else None, text[line.end() :] if line else text)


def _poses(keys: VehicleFile, present: set[str], T: FloatArray, computed: FloatArray | None) -> Remarks:
    if computed is not None:
        for contradiction in contradictions(T, computed, keys.dof):
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
        yield "warning", "thrusters", f"a position is over {FARTHEST_ARM:g} m off; check its unit"
    for i, thruster in enumerate(keys.thrusters):
        if any(
            t.position == thruster.position and t.direction == thruster.direction for t in keys.thrusters[:i]
        ):
            yield "warning", f"thrusters[{i}]", "the same position and direction as an earlier thruster"


def _reach(keys: VehicleFile, vehicle: Vehicle) -> Remarks:
    meant = vehicle.k if keys.rank is None else keys.rank
    if vehicle.rank != meant:
        yield (
            "error",
            "rank",
            f"T has rank {vehicle.rank} but {meant} is asked for; leave out of 'dof' what no thruster moves "
            f"independently, or write 'rank: {vehicle.rank}' if that is meant",
        )
    for direction in unreachable(vehicle):
        yield "warning", "T", f"no thruster pushes {direction}"
    condition = _condition(vehicle)
    if condition > CONDITION:
        yield (
            "warning",
            "T",
            f"close to losing a direction: condition number {condition:.0f}, above {CONDITION:g}",
        )
    strongest = np.abs(vehicle.T / vehicle.row_lengths[:, None]).max(axis=0)
    for i in np.flatnonzero(strongest <= RANK_TOLERANCE):  # by nothing, or by rounding such as cos 90 deg
        yield "warning", "T", f"thruster {i} moves no controlled DOF; leave it out, or name the DOF it moves"


def _limits(keys: VehicleFile, vehicle: Vehicle) -> Remarks:
    low, high = vehicle.f_min, vehicle.f_max
    for i in np.flatnonzero((low > 0) | (high < 0)):
        yield (
            "warning",
            "f_min" if low[i] > 0 else "f_max",
            f"thruster {i} can't stop: 0 N is outside its limits",
        )
    for i in np.flatnonzero(low == high):
        yield "warning", "f_max", f"thruster {i} has f_min = f_max = {low[i]:g} N; it can't be commanded"
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


def _weights(vehicle: Vehicle) -> Remarks:
    spread = np.linalg.cond(vehicle.H)
    if spread > WIDEST_WEIGHTS:
        yield (
            "warning",
            "weights",
            f"differ by a factor of {spread:.0e}; iterative solvers lose digits over that",
        )


def _failures(vehicle: Vehicle) -> Remarks:
    whole = _condition(vehicle)
    lost: dict[str, list[str]] = {}
    for i in range(vehicle.n):
        try:
            degraded = vehicle.with_fault(i)
        except VehicleError:
            lost.setdefault("no thruster is left", []).append(str(i))
            continue
        if degraded.rank < vehicle.rank:
            gone = " and ".join(unreachable(degraded))
            lost.setdefault(f"nothing pushes {gone}", []).append(str(i))
        elif (worse := _condition(degraded)) > WORSE * whole:
            lost.setdefault(f"a direction is all but lost (condition {worse:.0f})", []).append(str(i))
    for what, thrusters in lost.items():
        yield "warning", "T", f"without thruster {' or '.join(thrusters)}, {what}"


def _exact(vehicle: Vehicle) -> Remarks:
    try:
        steps = exact(vehicle).worst_case_steps
    except NotApplicable as reason:
        yield "warning", "T", str(reason)
        return
    yield (
        "note",
        "T",
        f"d = {vehicle.nullity} (thrusters less rank): the exact method takes {steps} steps at worst",
    )


def unreachable(vehicle: Vehicle) -> list[str]:
    """The directions of wrench that no working thruster pushes, in words: ``pitch``, ``roll - 0.2 sway``.

    One a lost rank; coefficients are per row length of T, as rank is.
    """
    U = np.linalg.svd(vehicle.TP / vehicle.row_lengths[:, None])[0]
    directions = U[:, vehicle.rank :].T
    words = []
    for direction in _reduced(directions):
        terms = [
            f"{'-' if c < 0 else '+'} {'' if abs(abs(c) - 1) < 5e-3 else f'{abs(c):.2g} '}{axis}"
            for c, axis in zip(direction, vehicle.dof, strict=True)
            if abs(c) > 0.01
        ]
        words.append(" ".join(terms).removeprefix("+ "))
    return words


def _reduced(basis: FloatArray) -> FloatArray:
    # Row echelon form with the largest pivots: each direction in as few axes as may be.
    rows = basis.copy()
    for i in range(len(rows)):
        j = int(np.argmax(np.abs(rows[i])))
        rows[i] /= rows[i, j]
        for other in range(len(rows)):
            if other != i:
                rows[other] -= rows[other, j] * rows[i]
    return rows


def _condition(vehicle: Vehicle) -> float:
    sigma = np.linalg.svd(vehicle.TP / vehicle.row_lengths[:, None], compute_uv=False)
    return float(sigma[0] / sigma[vehicle.rank - 1])


def _facts(vehicle: Vehicle) -> Facts:
    try:
        steps = exact(vehicle).worst_case_steps
    except NotApplicable:
        steps = None
    v = vehicle
    return Facts(v.name, v.k, v.n, v.rank, v.nullity, _condition(v), steps)


def _round(value: float) -> bool:
    # One digit and zeros, as in 40, 200 or 1.
    return float(f"{value:.0e}") == value
