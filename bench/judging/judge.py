"""Verdict on the answers to a question: errors, distances to the optimum, losses."""

from collections.abc import Sequence
from typing import SupportsFloat

import numpy as np

from alloc import Allocation, Label, NotApplicable, Status
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray, StatusArray
from alloc.formulations import find_formulation
from alloc.formulations.hard import FORMULATION as HARD
from alloc.formulations.scaled import FORMULATION as SCALED
from alloc.live.plain import ANY_DISTANCE
from alloc.qp.certificate import certify_many
from bench.demands import ATTAINED, longest
from bench.judging.faults import VIOLATED, Measured, faults, measure_answers, quantiles_by_level
from bench.judging.loss import FLOOR, gets_nothing, loss, relative_wrench_error
from bench.judging.question import Question
from bench.record import Judged

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
    doubt: FloatArray | float = 0.0,
    thorough: bool = True,
) -> Judged:
    """Judge ``answers`` to the demands of ``question``, one a demand in order, and over again from the first.

    ``wrench_tolerance`` is how far a SOLVED wrench may be off, relative to the vehicle's wrench scale: more
    for answers in single precision. ``doubt`` (N,) [N] is how far rounding of a demand moves its right
    answer; so much of a distance does not count. ``thorough`` adds duality gaps and what is lost, which cost
    most and are the same in each repeat. Every comparison is written so that NaN fails it.
    """
    seen = measure_answers(question, answers, formulation)
    wrong = faults(question, seen, formulation, limited, tolerance, wrench_tolerance)
    vehicle, finite, status = question.demands.vehicle, seen.finite, seen.status
    compared = finite & np.isfinite(seen.distance)
    N = len(question.demands.taus)
    distance = seen.distance - np.broadcast_to(doubt, N)[seen.demand]
    farthest = max(float(distance[compared].max()), 0.0) if compared.any() else None
    missed_max, missed_p50 = missed_shares(question, seen.F) if thorough else (None, None)
    middle, least = quantiles_by_level(seen.shares, 0.5, 0.0)
    demands, nothing = question.demands, np.zeros(N, dtype=bool)
    if thorough:
        nothing = gets_nothing(*demands.strong, seen.F[:N], demands.limits)
    return Judged(
        answers=len(seen.F),
        counts={s.name: int(np.count_nonzero(status == s)) for s in Status if (status == s).any()},
        wrench_error_max=[rounded(e) for e in seen.error[finite].max(axis=0)] if finite.any() else [],
        wrench_error_rel_max=_largest(seen.relative[finite]),
        limit_violation_max_N=_largest(seen.violation[finite]),
        distance_max_N=None if farthest is None else rounded(farthest),
        distance_rel_max=None if farthest is None else rounded(farthest / vehicle.f_scale),
        gap_rel_max=largest_gap(question, seen.F, status, formulation) if thorough else None,
        tolerance=tolerance,
        agrees=_agrees(farthest, tolerance, vehicle.f_scale),
        failed_after_failure=after_failure(seen.gave_up, attainable(question, formulation)[seen.demand]),
        loss=first_pass_loss(question, seen.F) if thorough else {},
        missed_max=missed_max,
        missed_p50=missed_p50,
        nothing_share=rounded(nothing.mean()) if nothing.size else 0.0,
        refused_longest=longest(~finite[:N] | nothing, question.demands.gaps) if thorough else 0,
        share_p50=[rounded(share) for share in middle],
        share_min=[rounded(share) for share in least],
        partial_by_weak=_partial_by_weak(question, seen),
        wrong="; ".join(_counted(what, mask, seen) for what, mask in wrong.items() if mask.any()),
    )


def _partial_by_weak(question: Question, seen: Measured) -> int:
    """Number of answers that say PARTIAL, and deliver each level of a demand but for its weak part."""
    if question.demands.hard_alpha is None:
        return 0
    whole = np.array([len(share) > 0 and min(share) == 1.0 for share in seen.shares], dtype=bool)
    return int(np.count_nonzero(whole & np.equal(seen.status, Status.PARTIAL)))


def attainable(question: Question, formulation: str = "") -> BoolArray:
    """Mask of demands (N,) that can be met, whatever rounding makes of them, but for what is weak.

    Given a ``formulation`` that leaves no weak direction out, of those that it can meet whole.

    The labels active and inactive leave out the boundary, where failures happen, so alpha* is used. But
    alpha* does not tell where a vehicle that must always thrust gets too small a demand; the label does.
    """
    demands = question.demands
    strong = not formulation or find_formulation(formulation).way is not None
    alpha = demands.alpha if strong or demands.hard_alpha is None else demands.hard_alpha
    within: BoolArray = (alpha > 1 + WRENCH_TOLERANCE) & (
        demands.labels_for(strong=strong) != Label.INFEASIBLE
    )
    return within


def after_failure(gave_up: BoolArray, within: BoolArray) -> float | None:
    """Share of attainable demands without thrusts among those that follow an answer without thrusts.

    It shows what a warm start or a reused object carries over. None where no demand follows a failure.
    """
    following = within[1:] & gave_up[:-1]
    return rounded(gave_up[1:][following].mean()) if following.any() else None


def largest_gap(question: Question, F: FloatArray, status: StatusArray, formulation: str) -> float | None:
    """The largest duality gap over the first pass, relative to the cost; None where no QP is answered.

    The gap needs no reference and bounds the distance to the optimum: see ``alloc.qp.certificate``.
    """
    definition = find_formulation(formulation)
    if definition.pose is None:
        return None
    taus = question.demands.taus
    N = len(taus)
    answered = np.isfinite(F[:N]).all(axis=1)
    if not definition.gives_way:  # then an answer that meets the wrench in part has no optimum
        answered &= status[:N] == Status.SOLVED
    if not answered.any():
        return None
    low, high = (np.broadcast_to(side, F[:N].shape) for side in question.demands.limits)
    try:
        posed = definition.pose(question.demands.vehicle)
        b, x = posed.scaled(taus[answered], F[:N][answered])
        lb, ub = (side[answered][:, posed.working] / posed.unit for side in (low, high))
        cost = np.einsum("ij,jk,ik->i", x, posed.qp.H, x) / 2
        gap = certify_many(posed.qp, b, x, (lb, ub)).gap
    except NotApplicable:
        return None
    return rounded((gap / np.maximum(cost, LEAST_COST)).max())


def first_pass_loss(question: Question, F: FloatArray) -> dict[str, float | None]:
    """``bench.judging.loss.loss`` over the first pass of the demands, against the hard optimum.

    On a vehicle with weak directions it is of the strong part, against the optimum of that.
    """
    demands = question.demands
    first, reference = F[: len(demands.taus)], question.right[HARD.name]
    if demands.hard_alpha is not None:
        optimum = question.right.get(SCALED.name, np.full_like(reference, np.nan))
        reference = np.where((demands.alpha >= ATTAINED)[:, None], optimum, np.nan)
    numbers = loss(*demands.strong, first, reference, demands.limits)
    return {key: None if value is None else rounded(value) for key, value in numbers.items()}


def missed_shares(question: Question, F: FloatArray) -> tuple[float | None, float | None]:
    """Largest and median share of an attainable demand's wrench that is not delivered, in the first pass [-].

    The median is over demands of at least FLOOR of ``wrench_scale``: of a log, most may ask for nothing.
    """
    demands = question.demands
    vehicle, taus = demands.strong
    scale = vehicle.wrench_scale
    error = relative_wrench_error(vehicle, taus, F[: len(taus)], demands.limits)
    missed = np.nan_to_num(error, nan=1.0)
    within = attainable(question)
    large = missed[within & (np.linalg.norm(taus / scale, axis=1) >= FLOOR)]
    return _largest(missed[within]), rounded(np.median(large)) if large.size else None


def _agrees(farthest: float | None, tolerance: float, f_scale: float) -> bool | None:
    """True if answers are as near as promised; None where no distance was promised."""
    if farthest is None:
        return None
    near = farthest <= tolerance * f_scale
    return None if near and tolerance >= ANY_DISTANCE else near


def rounded(value: SupportsFloat) -> float:
    """``value`` in six digits, more than any error is known to."""
    return float(f"{float(value):.6g}")


def _largest(values: FloatArray) -> float | None:
    return rounded(values.max()) if values.size else None


def _counted(what: str, mask: BoolArray, seen: Measured) -> str:
    """Errors by kind, how often, and by how much for limits: rounding looks unlike an error of the method."""
    most = f", by {seen.violation[mask].max():.2g} N at most" if what == VIOLATED else ""
    first = seen.demand[mask][0]
    return f"{what} ({np.count_nonzero(mask)} of {len(mask)} answers, first for demand {first}{most})"
