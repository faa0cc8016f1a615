"""Judges answers by equations alone, whatever their solver says of them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from alloc import (
    WRENCH_TOLERANCE,
    Allocation,
    BoolArray,
    FloatArray,
    Label,
    NotApplicable,
    Status,
    StatusArray,
    certify_many,
    find_formulation,
)
from alloc.formulations.hard import FORMULATION as HARD
from bench.judging.loss import loss, relative_wrench_error
from bench.judging.question import Question, right_answers
from bench.judging.shares import by_level, misstated
from bench.record import Judged

COMPARED = 256
"""Answers whose memory is compared; comparing all of them would take longer than measuring them."""
LEAST_COST = 5e-5
"""Cost of one thruster at 1 % of its limit. A smaller cost counts as this one: rounding must not look like a
large share of almost nothing."""


def judge(
    question: Question,
    answers: Sequence[Allocation],
    *,
    formulation: str,
    limited: bool,
    tolerance: float,
    wrench_tolerance: float = WRENCH_TOLERANCE,
    thorough: bool = True,
) -> Judged:
    """Judge ``answers`` to the demands of ``question``, one a demand in order, and over again from the first.

    ``wrench_tolerance`` is how far a SOLVED wrench may be off, relative to the vehicle's wrench scale: more
    for answers in single precision. ``thorough`` adds duality gaps and what is lost, which cost most and are
    the same in each repeat. Every comparison is written so that NaN fails it.
    """
    demands, vehicle = question.demands, question.demands.vehicle
    definition = find_formulation(formulation)
    thrusts, statuses, *_ = zip(*answers, strict=True)
    shares = [answer[4] if len(answer) > 4 else () for answer in answers]
    F, misshapen = stacked(thrusts, vehicle.n)
    # A board's log may hold any number; the ends of int8 are no statuses either.
    status: StatusArray = np.clip(statuses, -128, 127).astype(np.int8)
    demand = np.arange(len(F)) % len(demands.taus)
    finite: BoolArray = np.logical_and.reduce(np.isfinite(F), axis=1)
    f = np.where(finite[:, None], F, 0.0)
    right = right_answers(question, formulation)
    error = np.abs(f @ vehicle.TP.T - demands.taus[demand])
    relative = (error / vehicle.wrench_scale).max(axis=1)
    low, high = (np.broadcast_to(side, right.shape)[demand] for side in demands.limits)
    violation = np.maximum(f - high, low - f).max(axis=1).clip(min=0.0)
    distance = np.abs(f - right[demand]).max(axis=1)
    compared = finite & np.isfinite(distance)
    farthest = float(distance[compared].max()) if compared.any() else None

    solved: BoolArray = np.equal(status, Status.SOLVED)
    label = demands.labels[demand]
    gave_up = (status == Status.INFEASIBLE) | (status == Status.NOT_CONVERGED)
    attainable = (label == Label.INACTIVE) | (label == Label.ACTIVE)
    # The labels active and inactive leave out the boundary, where failures happen, so alpha* is used. But
    # alpha* does not tell where a vehicle that must always thrust gets too small a demand; the label does.
    within = (demands.alpha[demand] > 1 + WRENCH_TOLERANCE) & (label != Label.INFEASIBLE)
    met = relative <= wrench_tolerance
    wrong: dict[str, BoolArray] = {
        "not an array of n thrusts": misshapen,
        "a status that is none": ~np.isin(status, [s.value for s in Status]),
        "NaN or infinity although it says SOLVED or PARTIAL": ~finite & ~gave_up,
        "a thrust although it says that there is none": ~np.isnan(F).all(axis=1) & gave_up,
        "SOLVED, but the wrench is not met": solved & finite & ~met & (not definition.gives_way),
        "a limit is violated": finite & ~(violation <= 0.0) & limited,
        "SOLVED, but no thrust inside the limits gives this wrench": solved
        & (label == Label.INFEASIBLE)
        & (limited and not definition.gives_way),
        "says INFEASIBLE, but a thrust inside the limits gives this wrench": (status == Status.INFEASIBLE)
        & attainable,
        "shares of its levels that its thrusts do not deliver": finite
        & misstated(demands, demand, shares, f, formulation, tolerance),
        "shares memory with another answer: yesterday's changes when today's is made": shared(thrusts),
    }
    return Judged(
        answers=len(F),
        counts={s.name: int(np.count_nonzero(status == s)) for s in Status if (status == s).any()},
        wrench_error_max=[rounded(float(e)) for e in error[finite].max(axis=0)] if finite.any() else [],
        wrench_error_rel_max=_largest(relative[finite]),
        limit_violation_max_N=_largest(violation[finite]),
        distance_max_N=None if farthest is None else rounded(farthest),
        distance_rel_max=None if farthest is None else rounded(farthest / vehicle.f_scale),
        gap_rel_max=largest_gap(question, F, status, formulation) if thorough else None,
        tolerance=tolerance,
        agrees=None if farthest is None else farthest <= tolerance * vehicle.f_scale,
        failed_after_failure=after_failure(gave_up, within),
        loss=given_away(question, F) if thorough else {},
        missed_max=largest_miss(question, F) if thorough else None,
        share_p50=[rounded(share) for share in by_level(shares, 0.5)],
        share_min=[rounded(share) for share in by_level(shares, 0.0)],
        wrong="; ".join(_counted(what, mask, demand) for what, mask in wrong.items() if mask.any()),
    )


def after_failure(gave_up: BoolArray, attainable: BoolArray) -> float | None:
    """Of the attainable demands that follow an answer without thrusts, the share that got no thrusts either.

    It shows what a warm start or a reused object carries over. None where no demand follows a failure.
    """
    following = attainable[1:] & gave_up[:-1]
    return rounded(float(gave_up[1:][following].mean())) if following.any() else None


def largest_gap(question: Question, F: FloatArray, status: StatusArray, formulation: str) -> float | None:
    """The largest duality gap over the first pass, relative to the cost; None where no QP is answered.

    The gap needs no reference and bounds the distance to the optimum: see ``alloc.qp.certificate``.
    """
    definition = find_formulation(formulation)
    if definition.pose is None:
        return None
    taus = question.demands.taus
    N = len(taus)
    posed = definition.pose(question.demands.vehicle)
    answered = np.isfinite(F[:N]).all(axis=1)
    if not definition.gives_way:  # then an answer that meets the wrench in part has no optimum
        answered &= status[:N] == Status.SOLVED
    if not answered.any():
        return None
    b, x = posed.scaled(taus[answered], F[:N][answered])
    low, high = (np.broadcast_to(side, F[:N].shape) for side in question.demands.limits)
    lb, ub = (side[answered][:, posed.working] / posed.unit for side in (low, high))
    cost = np.einsum("ij,jk,ik->i", x, posed.qp.H, x) / 2
    try:
        gap = certify_many(posed.qp, b, x, (lb, ub)).gap
    except NotApplicable:
        return None
    return rounded(float((gap / np.maximum(cost, LEAST_COST)).max()))


def given_away(question: Question, F: FloatArray) -> dict[str, float | None]:
    """``bench.judging.loss.loss`` over the first pass of the demands, against the hard optimum."""
    demands = question.demands
    first = F[: len(demands.taus)]
    numbers = loss(demands.vehicle, demands.taus, first, question.right[HARD.name], demands.limits)
    return {key: None if value is None else rounded(value) for key, value in numbers.items()}


def largest_miss(question: Question, F: FloatArray) -> float | None:
    """The largest share of an attainable demand's wrench that is not delivered, over the first pass [-]."""
    demands = question.demands
    error = relative_wrench_error(demands.vehicle, demands.taus, F[: len(demands.taus)], demands.limits)
    attainable = np.isin(demands.labels, (Label.INACTIVE, Label.ACTIVE))
    return rounded(float(np.nan_to_num(error[attainable], nan=1.0).max())) if attainable.any() else None


def stacked(thrusts: Sequence[FloatArray], n: int) -> tuple[FloatArray, BoolArray]:
    """F (M, n), and which of the M answers are no (n,) arrays of real numbers; those are rows of NaN in F."""
    misshapen = np.array(
        [not isinstance(f, np.ndarray) or f.shape != (n,) or f.dtype.kind not in "fiu" for f in thrusts]
    )
    if misshapen.any():
        nothing = np.full(n, np.nan)
        thrusts = [nothing if bad else f for f, bad in zip(thrusts, misshapen, strict=True)]
    F: FloatArray = np.concatenate(thrusts).reshape(-1, n)
    return F, misshapen


def shared(thrusts: Sequence[FloatArray]) -> BoolArray:
    """Which answers overlap in memory with another one, of the first COMPARED.

    All answers are alive while they are compared, so overlap means that a method hands a buffer out again.
    Such a method does so within a few calls.
    """
    bounds = [
        np.lib.array_utils.byte_bounds(f) if isinstance(f, np.ndarray) else (0, 0) for f in thrusts[:COMPARED]
    ]
    low, high = np.array(bounds, dtype=np.int64).T
    order = np.argsort(low, kind="stable")
    overlap = np.zeros(len(thrusts), dtype=bool)
    overlap[order[1:]] = low[order[1:]] < np.maximum.accumulate(high[order])[:-1]
    return overlap


def rounded(value: float) -> float:
    """``value`` in six digits, more than any error is known to."""
    return float(f"{value:.6g}")


def _largest(values: FloatArray) -> float | None:
    return rounded(float(values.max())) if values.size else None


def _counted(what: str, mask: BoolArray, demand: NDArray[np.intp]) -> str:
    return f"{what} ({np.count_nonzero(mask)} of {len(mask)} answers, first for demand {demand[mask][0]})"
