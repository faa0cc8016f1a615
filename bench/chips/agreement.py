"""Comparison of the C's answers, on a board or an emulated processor, with those of its method in Python."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from alloc import Label, Status, build
from alloc.allocation import BoolArray, FloatArray, IndexArray, StatusArray
from alloc.c.selftest import AGREEMENT, ROUNDING, TRIES, largest_differences
from alloc.formulations import find_formulation
from alloc.kernels.tolerance import TOLERANCE, WRENCH_ERROR
from alloc.methods import recipe
from alloc.rivals import load
from bench.chips.count import CallCounts
from bench.chips.kernels import Kernel
from bench.demands import DemandSet
from bench.judging.faults import find_misstated_shares

ANSWERED = (Status.SOLVED, Status.PARTIAL)


@dataclass(frozen=True)
class Agreement:
    """Differences between the answers of C and Python.

    Attributes
    ----------
    distance_rel_max : largest |f - f of Python|, relative to the largest limit or thrust [-]
    other_verdicts : demands that one answers with another status than the other, where rounding does not
        decide; of a solver's C: off the boundary, that can be met and get no thrusts, or can't be met and are
        called met
    misstated : answers that say shares which their thrusts do not deliver
    wrong : what differs by more than tolerance and rounding explain, in words; empty where nothing does
    """

    distance_rel_max: float
    other_verdicts: int
    misstated: int = 0
    wrong: str = ""

    @property
    def agrees(self) -> bool:
        """True if every verdict is the same, every thrust, and every share that its thrusts deliver."""
        return not self.wrong


class Rounded(NamedTuple):
    """Changes of N answers that rounding may cause.

    Attributes
    ----------
    apart : (N,) how far it moves their thrusts at most [N]
    status : (TRIES, N) statuses of the answers that were moved
    """

    apart: FloatArray
    status: StatusArray


@np.errstate(invalid="ignore")  # a board's log may hold thrusts of any bits; a comparison with NaN is false
def agreement(kernel: Kernel, demands: DemandSet, counted: CallCounts) -> Agreement:
    """Compare a kernel's answers with its twin's in Python; the twin of a solver's C is an exact method.

    The verdicts must be the same wherever rounding does not decide. A solver may give up in place of calling
    a demand infeasible, and stop anywhere within its tolerance. Thrusts may differ by what rounding explains,
    and where they are as good (``_as_good``); a rule's within limits by all that its twin promises too, since
    a thrust that is beyond a limit by less counts as inside.
    """
    vehicle = demands.vehicle
    given = (demands.f_min, demands.f_max) if kernel.limits == "call" else (None, None)
    twin = build(kernel.twin, vehicle)
    F, status = twin.many(demands.taus, *given)
    met = status != Status.INFEASIBLE
    optimal = bool(find_formulation(twin.formulation).references)
    lost = twin.tolerance if twin.limited and not optimal else 0.0
    if kernel.solver:
        clear = demands.labels != Label.BOUNDARY
        answered = np.isin(counted.status, ANSWERED)
        tolerance = load(kernel.solver).TOLERANCE["default"][kernel.scalar]
        other = np.where(met, ~answered, counted.status == Status.SOLVED) & clear
        both = clear & answered & met
    else:
        tolerance = max(AGREEMENT[kernel.scalar], lost)
        other = (counted.status != status) & ~_either(kernel, demands, counted, status, twin.formulation)
        both = (counted.status != Status.INFEASIBLE) & met
    size = np.maximum(np.abs(F[both]).max(axis=1, initial=0.0), vehicle.f_scale)
    apart = np.abs(counted.F[both] - F[both]).max(axis=1, initial=0.0)
    near = apart <= tolerance * size
    if not kernel.solver and (other.any() or not near.all()):
        rounded = explained(kernel, demands, F, lost)
        near = apart <= tolerance * size + rounded.apart[both]
        near |= _as_good(kernel, demands, counted.F, F, optimal)[both]
        other &= ~(rounded.status == counted.status).any(axis=0)
    said = np.flatnonzero(np.isin(counted.status, ANSWERED))
    undelivered = find_misstated_shares(
        demands,
        said,
        list(counted.shares[said]),
        counted.F[said],
        twin.formulation,
        tolerance=AGREEMENT[kernel.scalar] / vehicle.n,  # demands are rounded to the scalar, T f is not
        wrench_tolerance=WRENCH_ERROR[kernel.scalar],
    )
    differing = (
        ("makes other thrusts than Python", np.flatnonzero(both)[~near]),
        *_verdicts(counted, status, other),
        ("says shares that its thrusts do not deliver", said[undelivered]),
    )
    return Agreement(
        distance_rel_max=float((apart / size).max(initial=0.0)),
        other_verdicts=int(np.count_nonzero(other)),
        misstated=int(undelivered.sum()),
        wrong="; ".join(
            f"{what} ({len(rows)} of {len(F)} answers, first for demand {rows[0]})"
            for what, rows in differing
            if len(rows)
        ),
    )


def _as_good(kernel: Kernel, demands: DemandSet, made: FloatArray, F: FloatArray, optimal: bool) -> BoolArray:
    """Mask of thrusts (N, n) inside the limits that are worth what those of F are, by the equations alone.

    Those of a rule miss no more of the wrench, but for a hundredth. Those of an optimum miss no more and cost
    no more, but for MET, and are asked only where F misses some of the wrench: beyond the edge of what can be
    met two right answers to a nearly symmetric vehicle differ by more than rounding explains.
    """
    vehicle, met = demands.vehicle, WRENCH_ERROR[kernel.scalar]
    low, high = demands.limits
    inside = (np.maximum(made - high, low - made) <= TOLERANCE[kernel.scalar] * vehicle.f_scale).all(axis=1)
    missed, least = (
        np.linalg.norm((each @ vehicle.TP.T - demands.taus) / vehicle.wrench_scale, axis=1)
        for each in (made, F)
    )
    if not optimal:
        return np.asarray(inside & (missed <= 1.01 * least))
    cost, cheapest = (np.einsum("ij,jk,ik->i", each, vehicle.H, each) for each in (made, F))
    good = (least > ROUNDING[kernel.scalar]) & (missed <= least + met) & (cost <= (1.0 + met) * cheapest)
    return np.asarray(inside & good)


def _either(
    kernel: Kernel, demands: DemandSet, counted: CallCounts, status: StatusArray, formulation: str
) -> BoolArray:
    """Mask of calls whose status may differ from the twin's, rounding of arguments aside.

    SOLVED for PARTIAL is true where its thrusts make the wrench to what its scalar can tell. On the boundary
    of the attainable set an exact answer turns, from SOLVED into what its formulation has beyond.
    """
    vehicle, definition = demands.vehicle, find_formulation(formulation)
    missed = np.abs((counted.F @ vehicle.TP.T - demands.taus) / vehicle.wrench_scale).max(axis=1)
    true: BoolArray = (
        (counted.status == Status.SOLVED)
        & (status == Status.PARTIAL)
        & (missed <= WRENCH_ERROR[kernel.scalar])
    )
    if not definition.references:
        return true
    beyond = Status.PARTIAL if definition.way else Status.INFEASIBLE
    turns = (demands.labels == Label.BOUNDARY) & np.isin(status, (Status.SOLVED, beyond))
    true |= turns & np.isin(counted.status, (Status.SOLVED, beyond))
    return true


def _verdicts(counted: CallCounts, status: StatusArray, other: BoolArray) -> Iterator[tuple[str, IndexArray]]:
    """Each pair of statuses, in words, and the answers that have it."""
    pairs = np.column_stack([counted.status, status])
    for said, expected in np.unique(pairs[other], axis=0).tolist():
        rows = np.flatnonzero(other & (pairs == (said, expected)).all(axis=1))
        name = {int(each): each.name for each in Status}
        yield f"says {name.get(said, said)} for {name[expected]}", rows


def explained(kernel: Kernel, demands: DemandSet, F: FloatArray, lost: float = 0.0) -> Rounded:
    """Largest changes of F (N, n) [N] by rounding of arguments, and of the end of a way.

    On the edge of what can be met it may move a weak thruster by far more than an argument moved. With sigma
    the root mean square of what random signs of the rounding do, the worst signs of p arguments do sqrt(p)
    sigma, as ``alloc.c.selftest`` has it for self-tests. The wrench at the end is rounded as well. ``lost``
    is a share that may be lost beyond rounding [-].
    """
    vehicle = demands.vehicle
    doubt = recipe(kernel.twin).doubt(vehicle, kernel.scalar)
    by = max(ROUNDING[kernel.scalar], doubt, lost)
    rng = np.random.default_rng(1999)
    low, high = (np.broadcast_to(side, F.shape) for side in demands.limits)
    wrench = np.maximum(np.abs(demands.taus), vehicle.wrench_scale)
    width = (low != high) * vehicle.f_scale  # zero width stays zero width
    allocate = build(kernel.twin, vehicle)
    squares, ends, statuses = np.zeros(len(F)), np.zeros(len(F)), list[StatusArray]()
    # An optimum answers the wrench that it makes; a rule may answer that otherwise, however exact it is.
    optimal = bool(find_formulation(allocate.formulation).references)
    end = (1.0 - by) * np.nan_to_num(F) @ vehicle.TP.T
    for _ in range(TRIES):
        tau_signs, low_signs, high_signs = (
            by * rng.choice([-1.0, 1.0], one.shape) for one in (wrench, low, high)
        )
        ends_at = () if vehicle.azimuths else (low + low_signs * width, high + high_signs * width)
        moved, status = allocate.many(demands.taus + tau_signs * wrench, *ends_at)
        statuses.append(status)
        squares += largest_differences(moved, F) ** 2 / TRIES
        if optimal:
            moved, _ = allocate.many(end + tau_signs * vehicle.wrench_scale, low, high)
            ends += largest_differences(moved, F) ** 2 / TRIES
    largest = np.sqrt((vehicle.k + 2 * vehicle.n) * squares) + np.sqrt(vehicle.k * ends)
    if doubt:  # where a demand is met in part, errors in a matrix are magnified twice (``alloc.c.selftest``)
        largest += squares / (by * vehicle.f_scale)
    return Rounded(largest, np.array(statuses))
