"""Kinds of wrong answers, found by equations alone, whatever status a solver returned."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from alloc import Allocation, Label, NotApplicable, Status, Vehicle, label
from alloc.allocation import EXACT_TOLERANCE, WRENCH_TOLERANCE, BoolArray, FloatArray, IndexArray, StatusArray
from alloc.formulations import Formulation, find_formulation, mixed
from alloc.vehicle.azimuth import SPARE, excess
from bench.demands import DemandSet
from bench.demands.strong import across, strong_demands, strong_vehicle
from bench.judging.question import Question, right_answers


def find_misstated_shares(
    demands: DemandSet,
    demand: IndexArray,
    shares: Sequence[Sequence[float]],
    f: FloatArray,
    formulation: str,
    tolerance: float,
    wrench_tolerance: float = WRENCH_TOLERANCE,
) -> BoolArray:
    """Mask of M answers with shares that their thrusts f (M, n) [N] do not deliver.

    By the formulation's way, the shares of an answer make a wrench of its demand, ``demands.taus[demand]``.
    It may differ from T P f by ``wrench_tolerance``, and by as much as thrusts ``tolerance`` apart, relative
    to the largest limit, may make. An answer that says nothing misstates nothing. Of a formulation without
    a way it is known only that shares lie in 0 … 1.
    """
    wrong = np.array([any(not 0.0 <= part <= 1.0 for part in share) for share in shares], dtype=bool)
    said = np.flatnonzero([len(share) > 0 for share in shares])
    vehicle, find_way = demands.vehicle, find_formulation(formulation).way
    if find_way is None or not said.size:
        return wrong
    try:
        parts = find_formulation(formulation).parts(vehicle)
    except NotApplicable:
        return wrong
    way = parts[0].way
    wrong[said] |= [len(shares[i]) != len(way.keep) for i in said.tolist()]
    rows = said[~wrong[said]]
    taken = np.array([shares[i] for i in rows.tolist()]).reshape(len(rows), len(way.keep))
    low, high = (
        np.broadcast_to(side, (len(demands.taus), vehicle.n))[demand[rows]] for side in demands.limits
    )
    begin = way.departure(low, np.maximum(low, high))
    seen, taus, allowed = (
        parts[0].vehicle,
        demands.taus[demand[rows]],
        wrench_tolerance + vehicle.n * tolerance,
    )
    if len(parts) == 1:
        end = way.delivered(taus, begin, taken)
    else:  # shares of a mixture don't tell those of its parts
        ends_at = low, np.maximum(low, high)
        each = [part.way.towards_many(taus, part.way.departure(*ends_at)) for part in parts]
        end = across(vehicle, mixed([ends for ends, _ in each], [part.w for part in parts]))
        reached = [shares[:, part.level_indices] for (_, shares), part in zip(each, parts, strict=True)]
        taken -= mixed(reached, [part.w for part in parts])
        wrong[rows] = ~(np.abs(taken).max(axis=1, initial=0.0) <= allowed)
    off = np.abs((f[rows] @ seen.TP.T - end) / seen.wrench_scale).max(axis=1, initial=0.0)
    wrong[rows] |= ~(off <= allowed)
    return wrong


def promised_wrench(demands: DemandSet, formulation: Formulation) -> tuple[Vehicle, FloatArray]:
    """Vehicle whose wrench answers are held to, and what it makes (N, k) where all is delivered [N, N m].

    Of a direction that is weak or counts in part neither says anything (``Vehicle.mixture``).
    """
    vehicle, taus = demands.vehicle, demands.taus
    if formulation.way is None:
        return vehicle, taus
    seen = formulation.subject(vehicle)
    if seen.rank == vehicle.rank:
        return seen, demands.strong[1]
    try:
        parts = formulation.parts(vehicle)
    except NotApplicable:
        return seen, across(vehicle, demands.strong[1])
    ends = []
    for part in parts:
        begin, all_of_it = (
            part.way.departure(vehicle.f_min, vehicle.f_max),
            np.ones((len(taus), len(part.way.keep))),
        )
        ends.append(part.way.delivered(taus, begin, all_of_it))
    return seen, across(vehicle, mixed(ends, [part.w for part in parts]))


def has_weak_part(demands: DemandSet) -> BoolArray:
    """Mask of demands (N,) with a part along a weak direction, which may be called met in part or whole."""
    part = np.abs(demands.taus - demands.strong[1]) / demands.strong[0].wrench_scale
    found: BoolArray = part.max(axis=1, initial=0.0) > ALL_OF_IT
    return found


def quantiles_by_level(shares: Sequence[Sequence[float]], *quantiles: float) -> list[list[float]]:
    """Each quantile of what was delivered of each level, over the answers that say it; empty without any."""
    said = [share for share in shares if len(share) > 0]
    if len(set(map(len, said))) != 1:  # a method of one's own may say anything
        said = [share for share in said if np.isfinite(share).all()]
    if len(set(map(len, said))) != 1:
        return [[] for _ in quantiles]
    parts = np.array(said, dtype=float)
    known = parts[np.isfinite(parts).all(axis=1)]
    return [np.quantile(known, q, axis=0).tolist() if len(known) else [] for q in quantiles]


VIOLATED = "a limit is violated"
OVER_CAP = 1e-6
"""Share of a cap by which the currents of an answer may exceed it by rounding [-]."""

ALL_OF_IT = EXACT_TOLERANCE / 1000
"""Miss of a wrench up to which nobody may call it met in part, relative to ``wrench_scale`` [-]. From there
to WRENCH_TOLERANCE both are right: rules draw the line at EXACT_TOLERANCE, their C by shares below that."""


class Measured(NamedTuple):
    """M answers as arrays, and what the equations say of each; no verdict yet.

    Attributes
    ----------
    F, status : (M, n) thrusts [N], rows of NaN where an answer is none, and (M,) what their method says
    demand : (M,) which demand each answers
    shares : what each says to deliver of its levels
    misshapen, shared : (M,) answers that are no n thrusts; whose memory is another answer's too
    error, relative : (M, k) |T P f - tau| [N, N m], and (M,) its largest entry over ``wrench_scale`` [-]
    violation, distance : (M,) how far outside the limits, and from the right answer [N]
    """

    F: FloatArray
    status: StatusArray
    demand: IndexArray
    shares: list[Sequence[float]]
    misshapen: BoolArray
    shared: BoolArray
    error: FloatArray
    relative: FloatArray
    violation: FloatArray
    distance: FloatArray

    @property
    def finite(self) -> BoolArray:
        """Mask of answers that are finite in all entries, (M,)."""
        finite: BoolArray = np.logical_and.reduce(np.isfinite(self.F), axis=1)
        return finite

    @property
    def gave_up(self) -> BoolArray:
        """Mask of answers that claim no thrusts exist, (M,)."""
        return np.isin(self.status, (Status.INFEASIBLE, Status.NOT_CONVERGED))


def measure_answers(question: Question, answers: Sequence[Allocation], formulation: str) -> Measured:
    """The answers to the demands of the question, in order and over again from the first, as arrays."""
    demands, vehicle = question.demands, question.demands.vehicle
    thrusts, statuses, *_ = zip(*answers, strict=True)
    F, misshapen = stack_thrusts(thrusts, vehicle.n)
    demand = np.arange(len(F)) % len(demands.taus)
    finite = np.logical_and.reduce(np.isfinite(F), axis=1)
    f = np.where(finite[:, None], F, 0.0)
    right = right_answers(question, formulation)
    definition = find_formulation(formulation)
    seen, asked = promised_wrench(demands, definition)
    error = np.abs(f @ seen.TP.T - asked[demand])
    low, high = (np.broadcast_to(side, right.shape)[demand] for side in demands.limits)
    beyond = excess(vehicle.turning, f, low, high, SPARE * vehicle.f_scale).max(axis=1)
    return Measured(
        F=F,
        # A board's log may hold any number; the ends of int8 are no statuses either.
        status=np.clip(statuses, -128, 127).astype(np.int8),
        demand=demand,
        shares=[answer[4] if len(answer) > 4 else () for answer in answers],
        misshapen=misshapen,
        shared=find_shared_memory(thrusts),
        error=error,
        relative=(error / seen.wrench_scale).max(axis=1),
        violation=beyond.clip(min=0.0),
        distance=np.abs(f - right[demand]).max(axis=1),
    )


def faults(
    question: Question,
    seen: Measured,
    formulation: str,
    limited: bool,
    tolerance: float,
    wrench_tolerance: float = WRENCH_TOLERANCE,
) -> dict[str, BoolArray]:
    """Error kind → mask (M,) of affected answers; the distance to the optimum is not asked."""
    demands, definition = question.demands, find_formulation(formulation)
    vehicle = demands.vehicle
    strong = definition.way is not None
    finite, gave_up, label = seen.finite, seen.gave_up, demands.labels_for(strong=strong)[seen.demand]
    solved: BoolArray = np.equal(seen.status, Status.SOLVED)
    attainable = (label == Label.INACTIVE) | (label == Label.ACTIVE)
    met = seen.relative <= wrench_tolerance
    f = np.where(finite[:, None], seen.F, 0.0)
    idle = np.abs(f[:, vehicle.readiness == 0]).max(axis=1, initial=0.0)
    return {
        "not an array of n thrusts": seen.misshapen,
        "a status that is none": ~np.isin(seen.status, [s.value for s in Status]),
        "NaN or infinity although it says SOLVED or PARTIAL": ~finite & ~gave_up,
        "a thrust although it says that there is none": ~np.isnan(seen.F).all(axis=1) & gave_up,
        "SOLVED, but the wrench is not met": solved & finite & ~met & (not definition.gives_way),
        "PARTIAL, but its thrusts make all of the wrench": np.equal(seen.status, Status.PARTIAL)
        & finite
        & attainable
        & (seen.relative <= ALL_OF_IT)
        & (seen.violation <= 0.0)
        & ~np.array([any(part < 1.0 for part in share) for share in seen.shares], dtype=bool)
        & ~(strong & has_weak_part(demands)[seen.demand])
        & (not definition.gives_way),
        "a thrust on a thruster that is off": finite & (idle > wrench_tolerance * vehicle.f_scale),
        VIOLATED: finite & ~(seen.violation <= 0.0) & limited,
        "draws more current than the cap": finite & _over_cap(demands, f),
        "SOLVED, but no thrust inside the limits gives this wrench": solved
        & (label == Label.INFEASIBLE)
        & (limited and not definition.gives_way),
        "says INFEASIBLE, but a thrust inside the limits gives this wrench": (
            seen.status == Status.INFEASIBLE
        )
        & attainable,
        "shares of its levels that its thrusts do not deliver": finite
        & find_misstated_shares(demands, seen.demand, seen.shares, f, formulation, tolerance),
        "shares memory with another answer: a later call overwrites an earlier result": seen.shared,
    }


def _over_cap(demands: DemandSet, f: FloatArray) -> BoolArray:
    """Mask of thrusts (M, n) [N] whose currents together exceed the cap of the calls; none without one."""
    cap, volts = demands.supply
    if cap is None:
        return np.zeros(len(f), dtype=bool)
    over: BoolArray = ~(demands.vehicle.draw(volts).amps(f).sum(axis=1) <= cap * (1.0 + OVER_CAP))
    return over


def first_wrong(
    vehicle: Vehicle,
    taus: FloatArray,
    f_min: FloatArray | None,
    f_max: FloatArray | None,
    answers: Sequence[Allocation],
    **promises: Any,
) -> str:
    """First answer that is wrong by the equations, and how; empty for none.

    Limits are (N, n) [N], None for the vehicle's. No optimum is worked out, for a log may be long; whether
    a demand can be met is asked of those alone that are called INFEASIBLE.
    """
    N = len(taus)
    labels = np.full(N, Label.BOUNDARY, np.int8)  # which either status may have
    refused = [i for i, answer in enumerate(answers) if answer.status == Status.INFEASIBLE]
    low, high = (None if side is None else side[refused] for side in (f_min, f_max))
    asked = vehicle, taus[refused]
    if find_formulation(promises["formulation"]).way:
        asked = strong_vehicle(vehicle), strong_demands(*asked)
    labels[refused] = label(*asked, f_min=low, f_max=high).label
    alpha = np.full(N, np.nan)
    demands = DemandSet(
        name="log", vehicle=vehicle, taus=taus, labels=labels, alpha=alpha, f_min=f_min, f_max=f_max
    )
    question = Question(demands, {promises["formulation"]: np.full((N, vehicle.n), np.nan)}, {})
    seen = measure_answers(question, answers, promises["formulation"])
    kinds = faults(question, seen, **promises)
    found = [(int(which.argmax()), what) for what, which in kinds.items() if which.any()]
    if not found:
        return ""
    first, what = min(found)
    most = f", by {seen.violation[first]:.2g} N" if what == VIOLATED else ""
    return f"demand {first}, counted from 0: {what}{most}"


def stack_thrusts(thrusts: Sequence[FloatArray], n: int) -> tuple[FloatArray, BoolArray]:
    """F (M, n), and which of the M answers are no (n,) arrays of real numbers; those are rows of NaN in F."""
    misshapen = np.array(
        [not isinstance(f, np.ndarray) or f.shape != (n,) or f.dtype.kind not in "fiu" for f in thrusts]
    )
    if misshapen.any():
        nothing = np.full(n, np.nan)
        thrusts = [nothing if bad else f for f, bad in zip(thrusts, misshapen, strict=True)]
    F: FloatArray = np.asarray(np.concatenate(thrusts)).reshape(-1, n)  # a mask would hide what is wrong
    return F, misshapen


def find_shared_memory(thrusts: Sequence[FloatArray]) -> BoolArray:
    """Mask of answers that overlap in memory with another one.

    All answers are alive while they are compared, so overlap means that a method hands a buffer out again.
    """
    own = [isinstance(f, np.ndarray) and f.base is None and f.flags.owndata for f in thrusts]
    if all(own) and len(set(map(id, thrusts))) == len(thrusts):  # the usual case, without a look at addresses
        return np.zeros(len(thrusts), dtype=bool)
    bounds = [np.lib.array_utils.byte_bounds(f) if isinstance(f, np.ndarray) else (0, 0) for f in thrusts]
    low, high = np.array(bounds, dtype=np.int64).T
    order = np.argsort(low, kind="stable")
    overlap = np.zeros(len(thrusts), dtype=bool)
    overlap[order[1:]] = low[order[1:]] < np.maximum.accumulate(high[order])[:-1]
    return overlap
