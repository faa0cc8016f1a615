"""Remarks on geometry: poses and their mirror images, columns of T, directions, printed digits."""

from collections.abc import Iterator, Mapping
from itertools import combinations, islice
from math import comb
from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc.allocation import BoolArray, FloatArray
from alloc.lint.failures import lost_directions
from alloc.lint.report import FARTHEST_ARM, Remark, error, note, warning
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.condition import condition, wrench_doubt
from alloc.vehicle.degeneracy import FLAT
from alloc.vehicle.file import called, find_file, list_vehicles, reaction_torques, suspects
from alloc.vehicle.geometry import DOF, IMAGES, alike, contradictions, refusals
from alloc.vehicle.geometry import decimals as printed_decimals
from alloc.vehicle.keys import VehicleFile

FEWEST, MOST = 4, 12
"""Decimals of a T that looks printed: with fewer, columns depend on each other by chance; with more the last
digit is near rounding."""
LEAST = 1e-4
"""Share of a row's largest entry from which on one is odd: what a slip changes by less, rounding does too."""
SURE = 4
"""Digits from which on two numbers that differ in one, or in two that are exchanged, look like a slip."""
SETS = 50_000
"""Most sets of columns that are looked at, within a second."""


def decimals(T: FloatArray) -> int | None:
    """Most decimals of an entry of T; None where these are not between FEWEST and MOST."""
    digits = printed_decimals(T)
    return digits if FEWEST <= digits <= MOST else None


def nearly_dependent(vehicle: Vehicle, digits: int) -> tuple[int, int]:
    """Number of sets of rank T columns that depend on each other but for their last digit, and of all sets.

    With rows of T in unit of ``row_lengths`` and columns of one length, half of the last decimal moves the
    least singular value of a set by at most the Frobenius norm of what it moves its entries by (Weyl). A set
    whose least singular value is no larger may be dependent in truth; one at rounding, FLAT, is so in print.
    """
    A = vehicle.T / vehicle.row_lengths[:, None]
    lengths = np.linalg.norm(A, axis=0)
    on, r = np.intersect1d(vehicle.working, np.flatnonzero(lengths)), vehicle.rank
    count = comb(len(on), r)
    if not r or count > SETS:
        return 0, 0
    A, lengths = A[:, on] / lengths[on], lengths[on]
    sets = np.array(list(islice(combinations(range(len(on)), r), count)))
    sigma = np.linalg.svd(A.T[sets], compute_uv=False)[:, r - 1]
    half = 0.5 * 10.0**-digits
    moved = np.linalg.norm(half / vehicle.row_lengths) / lengths
    near = (sigma > FLAT) & (sigma <= np.sqrt((moved[sets] ** 2).sum(axis=1)))
    return int(near.sum()), count


class OddEntry(NamedTuple):
    """An entry of a table that alone breaks a symmetry which all others keep.

    Attributes
    ----------
    row, column : where it stands
    twins : the columns that are its column's images but for this entry
    expected : what it would be by them
    image : how they are its images, in words
    """

    row: int
    column: int
    twins: tuple[int, ...]
    expected: float
    image: str


def odd_entry(A: FloatArray, images: Mapping[str, FloatArray]) -> OddEntry | None:
    """The only entry of A (m, n) that breaks one of the symmetries ``images``; None without one.

    Each symmetry has its signs (s, m): an image of a column is its product with one of them. Every column
    has an image among the others, or is its own, but for two, which are each other's but for one entry. In a
    vehicle that is meant to be uneven some thruster has no image at all, or two entries differ. Of the two
    entries the one is odd whose size stands more rarely in its row.
    """
    # Rows of a few digits are printed to them all; in others numbers differ that a program rounded apart.
    most = np.abs(A).max(axis=1, initial=0.0)
    digits = [decimals(row) for row in A]
    near = np.array([1.01 * 10.0**-d if d else 1e-9 * top for d, top in zip(digits, most, strict=True)])
    for image, signs in images.items():
        off = np.abs(signs[:, :, None, None] * A[:, :, None] - A[:, None, :]) > near[:, None, None]
        alike: BoolArray = np.logical_or.reduce(~off.any(axis=1))
        lone, pairs = set(range(A.shape[1])), 0
        for i in range(A.shape[1]):
            others = [j for j in lone if alike[i, j] and j != i] if i in lone else []
            if others:
                pairs += not alike[i, i]
                lone -= {i, others[0]}
            elif alike[i, i]:
                lone -= {i}
        if len(lone) != 2 or not pairs:
            continue
        a, b = sorted(lone)
        for sign, one in zip(signs, off[:, :, a, b], strict=True):
            row = int(one.argmax())
            if one.sum() == 1 and abs(sign[row] * A[row, a] - A[row, b]) > LEAST * most[row]:
                return _oddest(np.abs(A), near, row, (a, b), sign[row] * A[row], image)
    return None


def _oddest(
    sizes: FloatArray, near: FloatArray, row: int, pair: tuple[int, int], reflected: FloatArray, image: str
) -> OddEntry:
    """The one of a pair whose entry in a row is the odd one, with all that are as its twin is."""
    often = [int((np.abs(sizes[row] - sizes[row, i]) <= near[row]).sum()) for i in pair]
    twin, odd = pair if often[0] >= often[1] else pair[::-1]
    others = np.delete(np.arange(len(sizes)), row)
    twins = np.flatnonzero(
        (np.abs(sizes - sizes[:, [twin]]) <= near[:, None]).all(axis=0)
        & (np.abs(sizes - sizes[:, [odd]]) <= near[:, None])[others].all(axis=0)
    )
    return OddEntry(row, odd, tuple(twins.tolist()), float(reflected[twin]), image)


def slips(a: float, b: float) -> tuple[int, bool]:
    """Number of decimal digits in which two numbers differ, and whether they are two that are exchanged.

    Numbers with fewer than SURE digits differ in all of them: there one digit is no coincidence.
    """
    texts = [np.format_float_positional(abs(each), trim="k").split(".") for each in (a, b)]
    before, behind = (max(len(text[side]) for text in texts) for side in (0, 1))
    first, second = (text[0].zfill(before) + text[1].ljust(behind, "0") for text in texts)
    apart = [(x, y) for x, y in zip(first, second, strict=True) if x != y]
    if min(len(each.strip("0")) for each in (first, second)) < SURE:
        return before + behind, False
    return len(apart), len(apart) == 2 and apart[0] == apart[1][::-1]


CONDITION = 20.0
"""Condition number, with rows of unit length, above which a direction is nearly lost: a push in the weakest
direction then takes 20 times the thrust of one in the strongest. Published vehicles lie below 4."""
TRACE, NOISE = 1e-3, 1e-9
"""Shares of a row's largest entry between which another one looks like a rounded angle: 1.57 rad for a right
one leaves 8e-4, 1.5708 leaves 4e-6, and arithmetic alone 1e-16."""
NEARLY = 0.05
"""Share by which an arm differs from its mirror image's that may be meant to be alike."""
WIDEST_WEIGHTS = 1e4  # a wider spread costs an iterative solver half of its digits


def on_columns(keys: VehicleFile, T: FloatArray) -> Iterator[Remark]:
    """Remarks on columns of T (k, n) that no thruster can make, and on moments that propellers explain."""
    n = T.shape[1]
    moments = reaction_torques(keys, n)
    published, names = suspects(keys, n), called(keys, n)
    refused = refusals(T, keys.dof, moments, names)
    for i, refusal in refused.items():
        if i in published:
            yield warning("suspect", f"taken as published: {refusal}")
        else:
            yield error("T", f"{refusal}; to take it as published, write 'suspect: [{i}]'")
    for i in sorted(published - refused.keys()):
        yield warning("suspect", f"{names[i]} is a thrust along a line; leave it out")
    if not moments.any() and (typical := alike(T, keys.dof)):
        yield warning(
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
        yield error(
            "rank",
            f"T has rank {vehicle.rank} but {meant} is asked for{missing}; leave out of 'dof' what no"
            f" thruster moves independently, or write 'rank: {vehicle.rank}' if that is meant",
        )
    else:
        for direction in unreachable(vehicle):
            yield warning("T", f"no thruster pushes {direction}")
    if (c := condition(vehicle)) > CONDITION:
        yield warning(
            "T",
            f"close to losing a direction: condition number {c:.2g}, above {CONDITION:g}. The weakest takes "
            f"{c:.2g} times the thrust of the strongest, and rounding alone moves thrusts by up to "
            f"{wrench_doubt(vehicle):.1g} of the largest limit",
        )
    strongest = np.abs(vehicle.T / vehicle.row_lengths[:, None]).max(axis=0)
    for i in np.flatnonzero(strongest <= RANK_TOLERANCE):  # 0, or rounding such as cos 90 deg
        name = vehicle.called(int(i))
        yield warning("T", f"{name} moves no controlled DOF; leave it out, or name the DOF it moves")


def on_digits(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on a printed T whose last digits decide which thrusters depend on each other."""
    if keys.T is None or (digits := decimals(vehicle.T)) is None:
        return
    near, count = nearly_dependent(vehicle, digits)
    if near:
        yield note(
            "T",
            f"looks like a symmetric vehicle printed to {digits} decimals: {near} of {count} sets of"
            f" {vehicle.rank} thrusters depend on each other but for the last digit; poses ('thrusters') give"
            " it exactly",
        )


def on_odd_entry(keys: VehicleFile, T: FloatArray) -> Iterator[Remark]:
    """A remark on the one entry of T, or of the poses, that breaks a symmetry which all others keep."""
    turns = {words: np.array(signs) for words, signs in IMAGES.items() if words}
    if keys.T is not None:
        A, rows, key, about = T, list[str](keys.dof), "T", np.zeros(len(T))
        six = [DOF.index(axis) for axis in keys.dof]
        images = {words: np.outer([1, -1], signs[six]) for words, signs in turns.items()}
    elif keys.thrusters:
        A = np.array([(*each.position, *each.direction) for each in keys.thrusters]).T
        rows, key = [f"{axis} of the {part}" for part in ("position", "direction") for axis in "xyz"], ""
        about = np.array([*keys.center_of_mass, 0.0, 0.0, 0.0])
        images = {
            words: np.array([[*signs[:3], *(way * signs[:3])] for way in (1, -1)])
            for words, signs in turns.items()
        }
    else:
        return
    if (odd := odd_entry(A - about[:, None], images)) is None:
        return
    has, expected = float(A[odd.row, odd.column]), float(f"{odd.expected + about[odd.row]:.12g}")
    differing, exchanged = slips(has, expected)
    if differing != 1 and not exchanged and abs(has - expected) > NEARLY * abs(expected):
        return
    names = called(keys, A.shape[1])
    twins = ", ".join(names[i] for i in odd.twins)
    # A thruster that was moved on purpose, by so many centimetres, may differ in one digit too.
    yield (warning if exchanged else note)(
        key or f"thrusters[{odd.column}]",
        f"{rows[odd.row]} of {names[odd.column]} is {has:.10g}; by its twins ({twins}) it would be"
        f" {expected:.10g}{', two digits exchanged' * exchanged}, and every other entry has its"
        f" image{odd.image}; mend it unless it is meant",
    )


def on_traces(keys: VehicleFile, vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on entries of T so small that they look like rounded angles, on which an axis may hang."""
    sizes = np.abs(vehicle.T) / vehicle.row_lengths[:, None]
    found = np.argwhere((sizes > NOISE) & (sizes < TRACE * sizes.max(axis=1, keepdims=True)))
    if not len(found):
        return
    row, i = found[0]
    more = f", and {len(found) - 1} more like it" if len(found) > 1 else ""
    yield note(
        "thrusters" if keys.T is None else "T",
        f"{vehicle.dof[row]} of {vehicle.called(int(i))} is {vehicle.T[row, i]:.2g}{more}; if an angle was"
        " rounded, as 1.57 for a right one, mend it: after a failure an axis may be lost by so little",
    )


def on_weights(vehicle: Vehicle) -> Iterator[Remark]:
    """A remark on an H that is spread too widely for iterative solvers."""
    spread = np.linalg.cond(vehicle.H)
    if spread > WIDEST_WEIGHTS:
        yield warning(
            "weights", f"differ by a factor of {spread:.0e}; iterative solvers lose digits over that"
        )


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


def on_name(keys: VehicleFile, path: Path) -> Iterator[Remark]:
    """A remark on a file that has the name of a shipped vehicle, and is another file."""
    if keys.name in list_vehicles() and not path.samefile(find_file(keys.name)):
        yield note("name", f"{keys.name} is a shipped vehicle, too; with another name tables tell them apart")


def on_poses(
    keys: VehicleFile, present: set[str], T: FloatArray, computed: FloatArray | None
) -> Iterator[Remark]:
    """Remarks on frame and poses, and on T (k, n) against the T ``computed`` from the poses.

    ``present`` holds the keys that stand in the file.
    """
    if computed is not None:
        for contradiction in contradictions(T, computed, keys.dof, called(keys, T.shape[1])):
            yield error("T", f"{contradiction}; correct the one that is wrong, or leave it out")
    if "frame" not in present:
        yield note("frame", "no 'frame' given; x forward, y starboard, z down (frd) is taken for granted")
    if keys.thrusters is None:
        if "center_of_mass" in present:
            yield warning("center_of_mass", "has no effect without thrusters; put it into T, or leave it out")
        return
    positions = np.array([thruster.position for thruster in keys.thrusters])
    middle = positions.mean(axis=0)
    reach = np.linalg.norm(positions - middle, axis=1).max()
    if "center_of_mass" not in present:
        yield note("center_of_mass", "not given; moments are taken about the origin of the positions")
    elif np.linalg.norm(np.array(keys.center_of_mass) - middle) > reach:
        yield warning("center_of_mass", "lies outside the thrusters; check its unit (m) and its origin")
    if np.abs(positions).max() > FARTHEST_ARM:
        yield warning("thrusters", f"a position is over {FARTHEST_ARM:g} m off; mm? divide by 1000")
    names = called(keys, len(keys.thrusters))
    for i, thruster in enumerate(keys.thrusters):
        for j, other in enumerate(keys.thrusters[:i]):
            if (other.position, other.direction) == (thruster.position, thruster.direction):
                yield warning(
                    f"thrusters[{i}]", f"{names[i]} has the same position and direction as {names[j]}"
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
            yield warning(
                f"thrusters[{j}]",
                f"{a} and {b} are mirror images that push opposite ways, unlike {len(alike)} other"
                f" {'pair' if len(alike) == 1 else 'pairs'}; is one reversed?",
            )
