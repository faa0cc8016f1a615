"""Equations to verdicts: what the answers are worth, whatever their solver said about them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from alloc import (
    WRENCH_TOLERANCE,
    Allocation,
    FloatArray,
    Label,
    NotApplicable,
    Status,
    StatusArray,
    pose_hard,
    pose_soft,
)
from bench.judging.loss import loss
from bench.judging.reference import Question
from bench.record import Judged

COMPARED = 256
"""Answers whose memory is compared; all pairs of all would take longer than what is measured."""
LEAST_COST = 5e-5
"""Costs below that of one thruster at 1 % of its limit count as that: no share of almost nothing."""

Mask = NDArray[np.bool_]


def judge(
    question: Question,
    answers: Sequence[Allocation],
    *,
    formulation: str,
    limited: bool,
    tolerance: float,
    thorough: bool = True,
) -> Judged:
    """Judge ``answers``: one a demand of ``question``, in order, over and over.

    ``thorough`` adds what costs most and is the same in each repeat: duality gaps, and what is lost.
    Every comparison is written so that NaN fails it.
    """
    vehicle = question.vehicle
    thrusts, statuses, _, _ = zip(*answers, strict=True)
    F, misshapen = stacked(thrusts, vehicle.n)
    status: StatusArray = np.array(statuses, dtype=np.int8)
    demand = np.arange(len(F)) % len(question.taus)
    finite: Mask = np.logical_and.reduce(np.isfinite(F), axis=1)
    f = np.where(finite[:, None], F, 0.0)
    error = np.abs(f @ vehicle.TP.T - question.taus[demand])
    relative = (error / vehicle.wrench_scale).max(axis=1)
    violation = np.maximum(f - vehicle.f_max, vehicle.f_min - f).max(axis=1).clip(min=0.0)
    distance = np.abs(f - reference_for(question, formulation)[demand]).max(axis=1)
    compared = finite & np.isfinite(distance)
    farthest = float(distance[compared].max()) if compared.any() else None

    solved: Mask = np.equal(status, Status.SOLVED)
    label = question.labels[demand]
    gave_up = (status == Status.INFEASIBLE) | (status == Status.NOT_CONVERGED)
    attainable = (label == Label.INACTIVE) | (label == Label.ACTIVE)
    # By alpha*, as labels leave out the boundary, where failures happen. But a vehicle that must always
    # thrust can be asked for too little as well, which alpha* does not tell.
    within = (question.alpha[demand] > 1 + WRENCH_TOLERANCE) & (label != Label.INFEASIBLE)
    met = relative <= WRENCH_TOLERANCE
    wrong: dict[str, Mask] = {
        "not an array of n thrusts": misshapen,
        "a status that is none": ~np.isin(status, [s.value for s in Status]),
        "NaN or infinity although it says SOLVED or PARTIAL": ~finite & ~gave_up,
        "a thrust although it says that there is none": ~np.isnan(F).all(axis=1) & gave_up,
        # A soft optimum gives way everywhere, so SOLVED means solved there, not met.
        "SOLVED, but the wrench is not met": solved & finite & ~met & (formulation != "soft"),
        "a limit is violated": finite & ~(violation <= 0.0) & limited,
        "SOLVED, but no thrust inside the limits gives this wrench": solved
        & (label == Label.INFEASIBLE)
        & (limited and formulation != "soft"),
        "says INFEASIBLE, but a thrust inside the limits gives this wrench": (status == Status.INFEASIBLE)
        & attainable,
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
        wrong="; ".join(_told(what, mask, demand) for what, mask in wrong.items() if mask.any()),
    )


def after_failure(gave_up: Mask, attainable: Mask) -> float | None:
    """Share of attainable demands without thrusts, of those asked right after another such answer.

    It is what a warm start or a reused object carries over. None where no demand follows a failure.
    """
    asked = attainable[1:] & gave_up[:-1]
    return rounded(float(gave_up[1:][asked].mean())) if asked.any() else None


def largest_gap(question: Question, F: FloatArray, status: StatusArray, formulation: str) -> float | None:
    """The largest duality gap over the first pass, relative to the cost; None where no QP is answered.

    It needs no reference, and bounds the distance to the optimum: see ``alloc.qp.certificate``.
    """
    if formulation not in ("hard", "soft"):
        return None
    from alloc import certify_many

    N = len(question.taus)
    posed = (pose_hard if formulation == "hard" else pose_soft)(question.vehicle)
    answered = np.isfinite(F[:N]).all(axis=1)
    if formulation == "hard":
        answered &= status[:N] == Status.SOLVED  # of a wrench met in part there is no hard optimum
    if not answered.any():
        return None
    b, x = posed.scaled(question.taus[answered], F[:N][answered])
    cost = np.einsum("ij,jk,ik->i", x, posed.qp.H, x) / 2
    try:
        gap = certify_many(posed.qp, b, x).gap
    except NotApplicable:
        return None
    return rounded(float((gap / np.maximum(cost, LEAST_COST)).max()))


def given_away(question: Question, F: FloatArray) -> dict[str, float | None]:
    """``bench.judging.loss`` over the first pass of the demands: what is lost against the exact answers."""
    N = len(question.taus)
    found = loss(question.vehicle, question.taus, F[:N], question.references["hard"])
    return {key: None if value is None else rounded(value) for key, value in found.items()}


def reference_for(question: Question, formulation: str) -> FloatArray:
    """(N, n) what this formulation must answer; rows of NaN where nothing is said.

    A practical rule (clip, shrink, …) has no optimum of its own, but nothing to do while T* tau lies
    inside the limits: there it must return that.
    """
    found = question.references.get(formulation)
    if found is not None:
        return found
    if formulation == "soft":  # biased everywhere, so nothing else is a reference for it
        return np.full((len(question.taus), question.vehicle.n), np.nan)
    inactive = question.labels == Label.INACTIVE
    return np.where(inactive[:, None], question.references["unlimited"], np.nan)


def stacked(thrusts: Sequence[FloatArray], n: int) -> tuple[FloatArray, Mask]:
    """F (M, n), and which answers were no (n,) arrays at all (NaN in F)."""
    shapes = [np.shape(f) for f in thrusts]
    misshapen = np.array([shape != (n,) for shape in shapes])
    if misshapen.any():
        nothing = np.full(n, np.nan)
        thrusts = [nothing if bad else f for f, bad in zip(thrusts, misshapen, strict=True)]
    F: FloatArray = np.concatenate(thrusts).reshape(-1, n)
    return F, misshapen


def shared(thrusts: Sequence[FloatArray]) -> Mask:
    """Which of the first answers, all of them alive now, overlap in memory with another one.

    A method that hands out buffers again shows that within a few calls, or within COMPARED.
    """
    first = thrusts[:COMPARED]
    low, high = np.array([np.lib.array_utils.byte_bounds(f) for f in first], dtype=np.int64).T
    order = np.argsort(low, kind="stable")
    overlap = np.zeros(len(thrusts), dtype=bool)
    overlap[order[1:]] = low[order[1:]] < np.maximum.accumulate(high[order])[:-1]
    return overlap


def rounded(value: float) -> float:
    """``value`` in six digits: more than any of these errors means."""
    return float(f"{value:.6g}")


def _largest(values: FloatArray) -> float | None:
    return rounded(float(values.max())) if values.size else None


def _told(what: str, mask: Mask, demand: NDArray[np.intp]) -> str:
    return f"{what} ({np.count_nonzero(mask)} of {len(mask)} answers, first for demand {demand[mask][0]})"
