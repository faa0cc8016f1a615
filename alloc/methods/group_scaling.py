"""Generalized inverse in groups of axes: each scaled until it fits, then added, and cut at the limits."""

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.load import LEAST, load, loads
from alloc.closed_forms.saturating import Bounds, Saturating
from alloc.formulations.group_scaling import FORMULATION as ANSWERED
from alloc.kernels import rules
from alloc.kernels.entry import (
    TAU,
    SeenArguments,
    all_thrusters,
    clamp_thrusts,
    closed_form,
    cover_arguments,
    refuse,
)
from alloc.kernels.fit import fit_to_limits
from alloc.program import Builder, Program, Scalar, Where, select
from alloc.program.sums import Terms, signed
from alloc.vehicle import Vehicle

FORMULATION = ANSWERED.name
MEANINGS = rules.MEANINGS
doubt = rules.doubt

UPWARDS = ("heave", "roll", "pitch")
"""Axes of the thrusters that push more up or down than to a side. They are one group."""
LEVEL = (("surge", "sway"), ("yaw",))
"""Axes of all other thrusters, in two groups."""


def build(vehicle: Vehicle) -> Saturating:
    """Prepare f = clip(sum of s_g B_g tau), s_g the largest factor in [0, 1] that makes group g fit alone.

    After what Suchit-Arunkumar/AUV-Thruster-Allocation describes and has flown. B_g holds of T* (eq. 9) the
    columns of one group's axes and the rows of its thrusters. The entries between groups are dropped, so
    where thrusters of one group push an axis of another, tau is missed also inside the limits.
    """
    parts, least = groups(vehicle), LEAST * vehicle.f_scale

    def one(tau: FloatArray, f: list[float], limits: Bounds) -> tuple[list[float], int]:
        thrusts = [0.0] * len(f)
        for B in parts:
            part: list[float] = B.dot(tau).tolist()
            too_large = load(part, limits.pairs, least)
            thrusts = [whole + x / too_large for whole, x in zip(thrusts, part, strict=True)]
        return thrusts, 1

    def each(taus: FloatArray, F: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        total = np.zeros_like(F)
        for B in parts:
            part = taus @ B.T
            total += part / loads(part, low, high, least)[:, None]
        return total

    return Saturating(vehicle, FORMULATION, one, each, start=np.sum(parts, axis=0))


def groups(vehicle: Vehicle) -> list[FloatArray]:
    """(n, k) of each group that pushes anything: T* without the other groups' axes and thrusters."""
    G = generalized_inverse(vehicle)
    forces = {axis: np.abs(row) for axis, row in zip(vehicle.dof, vehicle.T, strict=True)}
    none = np.zeros(vehicle.n)
    up = forces.get("heave", none) > np.hypot(forces.get("surge", none), forces.get("sway", none))
    kept = [
        np.outer(thrusters, [axis in axes for axis in vehicle.dof])
        for thrusters, axes in [(up, UPWARDS), *((~up, axes) for axes in LEVEL)]
    ]
    return [G * mask for mask in kept if (G * mask).any()] or [0.0 * G]


def program(vehicle: Vehicle, limits: Where, scalar: Scalar) -> Program:
    """The same for a demand within any limits."""
    builder, parts = Builder(vehicle, limits, scalar), groups(vehicle)
    reached = {
        place for level, B in enumerate(parts) for place in cover_arguments(B, level) if place[0] != TAU
    }
    unused = [(TAU, int(j)) for j in np.flatnonzero(~np.any(parts, axis=(0, 1)))]
    seen = SeenArguments([*sorted(reached), *unused], builder)
    alone = []
    for level, B in enumerate(parts):
        x = closed_form(builder, B)
        alone.append({i: value for i, value in x.items() if B[i].any()})
        seen.know(level, alone[-1])
    seen.add(vehicle.working.tolist(), "0")
    refuse(builder, seen, [], exact=False)
    terms: dict[int, Terms] = {i: [] for i in vehicle.working.tolist()}
    for level, x in enumerate(alone):
        for i, value in fit_to_limits(builder, x, f"share{level}").thrusts.items():
            terms[i].append((False, value))
    f = clamp_thrusts(builder, {i: signed(row, builder.graph) for i, row in terms.items()}, builder.limits)
    met = rules.makes_tau(builder, f)
    builder.compute(met)
    return builder.program(all_thrusters(builder, f), select(met, Status.SOLVED, Status.PARTIAL))
