"""Rules of practice: T* tau, changed where it exceeds the limits, and the check that it still makes tau."""

from collections.abc import Callable, Mapping
from functools import reduce
from operator import add
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.closed_forms.inverse import generalized_inverse
from alloc.kernels import failures
from alloc.kernels.entry import (
    SeenArguments,
    all_thrusters,
    clamp_thrusts,
    closed_form,
    cover_arguments,
    refuse,
)
from alloc.kernels.tolerance import WRENCH_ERROR, computed_error_limit
from alloc.program import Builder, Expression, Program, Scalar, States, Where, least, most, select, size
from alloc.program.graph import lifted
from alloc.program.sums import Terms, gathered, product, shared_sums, signed, snapped
from alloc.vehicle import Vehicle
from alloc.vehicle.condition import promised, wrench_doubt

MEANINGS = {
    0: "f makes tau, inside the limits",
    1: "f lies inside the limits, but makes tau in part only",
    2: "limits of the call cross: f_min is above f_max for a thruster that is not off; f is left alone",
    -1: "there is no such fault; f is left alone",
    -2: "an argument is NaN, infinite or too large to add up; f is left alone",
}
"""Meaning of each value that the C function of a rule returns."""


class RuleAnswer(NamedTuple):
    """Answer of a rule to x = T* tau.

    Attributes
    ----------
    thrusts : by thruster [N]
    share : fraction of tau delivered [-]; None where the cut at the limits may change it
    hidden : wrench error over ``wrench_scale`` that rounding of T (f - x) may hide [-]
    working : factor 0 for a failed thruster, else 1; only where the C would not show the zero without it
    """

    thrusts: dict[int, Expression]
    share: Expression | None = None
    hidden: float = 0.0
    working: Mapping[int, Expression] = MappingProxyType({})


Rule = Callable[[Builder, dict[int, Expression]], RuleAnswer]
"""Function from x = T* tau of the working thrusters to thrusts, which are then cut at the limits."""


def apply_rule(
    rule: Rule, vehicle: Vehicle, limits: Where, scalar: Scalar, faults: States | None = None
) -> Program:
    """Program of a rule: f = T* tau, changed by the rule, cut at the limits; one for all ``faults``."""
    builder, G = Builder(vehicle, limits, scalar, faults), generalized_inverse(vehicle)
    x, seen = closed_form(builder, G), SeenArguments(cover_arguments(G), builder)
    changed = failures.drop_failed(builder, x, generalized_inverse) if faults else None
    if changed:
        x = changed.thrusts
        if (vehicle.f_min <= 0.0).all() and (vehicle.f_max >= 0.0).all():
            builder.limits = builder.limits.of_no_fault()  # a failed thruster's zero lies inside
    seen.know(0, x)
    seen.add(vehicle.working.tolist(), "0")
    refuse(builder, seen, [], exact=False)
    made = rule(builder, x)
    y = clamp_thrusts(builder, made.thrusts, builder.limits)
    y |= {i: each * y[i] for i, each in made.working.items()}  # compare the thrusts that are returned
    share = error_scale(builder, made.hidden)
    known, lost = [*builder.faults.values()] or [vehicle], _lost(builder, share, changed)
    if made.share is not None and vehicle.rank == vehicle.k:
        # T y = share tau but for rounding, and share |tau| <= |T| far, so the error of tau is at most
        # (1 - share) / share times |T| far: comparing the share is enough. Where a fault loses a direction,
        # each of the two errors gets half.
        most_of = 0.5 if any(lost) else 1.0
        far = [np.maximum(np.abs(state.f_min), np.abs(state.f_max)) for state in known]
        allowed = np.array([(share * np.abs(vehicle.TP) @ each).max() for each in far])
        met = (made.share >= builder.graph.by_fault(allowed / (most_of + allowed))).named("met")
        if any(lost):
            met = met & misses_nothing(builder, lost, most_of)
    else:
        rows = [[*row, *more] for row, more in zip(_missed(builder, share, G, x, y), lost, strict=True)]
        met = misses_nothing(builder, rows)
    builder.compute(met)
    return builder.program(all_thrusters(builder, y), select(met, Status.SOLVED, Status.PARTIAL))


def doubt(vehicle: Vehicle, scalar: Scalar) -> float:
    """Relative rounding of thrusts from products with T* and N'H [-]."""
    return promised(vehicle, 0.0)


def error_scale(builder: Builder, hidden: float = 0.0) -> FloatArray:
    """Per-axis scale (k, 1): the allowed wrench error becomes 1."""
    may = computed_error_limit(builder.vehicle, builder.scalar) - hidden
    share: FloatArray = 1.0 / (may * builder.vehicle.wrench_scale)[:, None]
    return share


def misses_nothing(builder: Builder, rows: list[Terms], at_most: float = 1.0) -> Expression:
    """The condition that the errors T f - tau over ``error_scale`` add up to at most ``at_most``.

    A sum keeps the NaN or infinity of a row that overflowed, and then the comparison fails; a maximum would
    drop a NaN. A sum also costs less.
    """
    missed = [signed(row).named(f"missed{r}") for r, row in enumerate(rows) if row]
    if not missed:
        return lifted(0.0, builder.graph) <= 1.0
    condition: Expression = reduce(add, map(size, missed)) <= at_most
    return condition.named("met")


def makes_tau(builder: Builder, f: dict[int, Expression]) -> Expression:
    """The condition T f = tau, whatever f is."""
    missed, at_most = wrench_missed(builder, f)
    return (missed <= at_most).named("met")


def wrench_missed(builder: Builder, f: dict[int, Expression]) -> tuple[Expression, float]:
    """The sum of the errors |T f - tau| over ``error_scale``, in a unit of its own, and the most allowed.

    The unit makes the entry of T that is there most often 1, which saves its products. The sum depends on
    every entry of tau, and is not finite where one of them is not.
    """
    rows, of_tau, unit = unit_errors(builder)
    made = gathered(rows[:, list(f)], list(f.values()), "v")
    total: list[Expression] = []
    for row, each, tau in zip(made, of_tau.tolist(), builder.tau, strict=True):
        minus = all(sign for sign, _ in row)  # a sign before the whole row is an instruction, and no size
        error = signed([*((sign != minus, value) for sign, value in row), (not minus, each * tau)])
        total.append(size(error.named(f"missed{len(total)}")))
    missed: Expression = reduce(add, total)
    return missed.named("missed"), 1.0 / unit


def unit_errors(builder: Builder) -> tuple[FloatArray, FloatArray, float]:
    """Factors (k, n) of thrusts and (k,) of tau in the errors of ``wrench_missed``, and their unit."""
    share = error_scale(builder)
    rows = snapped(share * builder.vehicle.TP)
    sizes, often = np.unique(np.abs(rows[rows != 0.0]), return_counts=True)
    unit = float(sizes[often.argmax()]) if sizes.size else 1.0
    return rows / unit, share[:, 0] / unit, unit


def sided(value: Expression, above: float, below: float) -> Expression:
    """A value times ``above`` where it is above zero, times ``below`` elsewhere; both have one sign."""
    if above == below:
        return above * value
    pair = above * value, below * value
    found: Expression = most(*pair) if above > below else least(*pair)
    return found


def shared_states(vehicle: Vehicle, scalar: Scalar) -> States:
    """The vehicle and the faults that one program can answer: those that round as the vehicle does."""
    rounds = wrench_doubt(vehicle) > WRENCH_ERROR[scalar]
    return {
        fault: state
        for fault, state in failures.rescaled_states(vehicle, generalized_inverse).items()
        if (wrench_doubt(state) > WRENCH_ERROR[scalar]) == rounds
    }


def _missed(
    builder: Builder, share: FloatArray, G: FloatArray, x: dict[int, Expression], y: dict[int, Expression]
) -> list[Terms]:
    """Rows of T f - tau over ``error_scale``, whose reciprocal is ``share``.

    T f - tau = T (f - T* tau) - (1 - T T*) tau, whose last part is rounding where no rank is lost.
    """
    vehicle = builder.vehicle
    moved = [(y[i] - x[i]).named(f"d{i}") for i in x]
    rows = shared_sums(product(share * vehicle.TP[:, list(x)], moved, "q").rows, "v")[1]
    if vehicle.rank < vehicle.k or wrench_doubt(vehicle) > WRENCH_ERROR[builder.scalar]:
        lost = product(share * (vehicle.TP @ G - np.eye(vehicle.k)), builder.tau, "u").rows
        rows = [of_f + of_tau for of_f, of_tau in zip(rows, lost, strict=True)]
    return rows


def _lost(builder: Builder, share: FloatArray, changed: failures.FaultThrusts | None) -> list[Terms]:
    """Rows of T f - tau over ``error_scale`` that a fault loses."""
    vehicle = builder.vehicle
    rows: list[Terms] = [[] for _ in vehicle.dof]
    if changed:
        by = share[:, 0] * (changed.a @ vehicle.TP.T)
        by[[state.rank == vehicle.rank for state in builder.faults.values()]] = 0.0
        for r in np.flatnonzero(by.any(axis=0)).tolist():
            rows[r].append((True, builder.graph.by_fault(by[:, r]) * changed.failed))
    return rows
