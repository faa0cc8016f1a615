"""The remarks on T and H: columns that no thruster makes, directions that nothing pushes, printed digits."""

from collections.abc import Iterator

import numpy as np

from alloc.allocation import FloatArray
from alloc.lint.digits import decimals, nearly_dependent, odd_entry, slips
from alloc.lint.failures import lost_directions
from alloc.lint.report import Remark, error, note, warning
from alloc.vehicle import RANK_TOLERANCE, Vehicle
from alloc.vehicle.condition import condition, wrench_doubt
from alloc.vehicle.file import called, reaction_torques, suspects
from alloc.vehicle.geometry import DOF, IMAGES, alike, refusals
from alloc.vehicle.keys import VehicleFile

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
