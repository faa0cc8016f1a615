"""HiGHS: primal active set for convex QPs inside a linear programming code, in C++."""

import os
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, disbelieved, meaning

REQUIRES = PACKAGE = "highspy"
VERSION = "1.16.0"
ALGORITHM = "primal active set"
LICENCE = "MIT"
# Not "warm": HiGHS takes a solution or a basis, and its QP code goes through the same iterations as without,
# whether qp_allow_hot_start is on or off, its default since 1.15 (docs/solvers.md).
STARTS: tuple[Start, ...] = ("cold", "reused")

_QUIET = {"output_flag": False, "qp_iteration_limit": 10_000, "threads": 1}
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    "tight": _QUIET
    | {
        "qp_regularization_value": 0.0,  # the default, 1e-7 on the diagonal of H, moves x by as much
        "primal_feasibility_tolerance": 1e-10,
        "dual_feasibility_tolerance": 1e-10,
    },
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 1e-5, "tight": 1e-6},
    "soft": {"default": 1e-3, "tight": 1e-3},
}

REGULARIZATION = 1e-7
"""HiGHS's own: what it adds to the diagonal of H, where SETTINGS don't say otherwise."""
DENIED = 1e-5
"""Most of the gradient that the multipliers may leave, as a share [-]. In 6,000 answers on odd vehicles it
was below 1e-7, or above 1e-2: HiGHS then calls x optimal that lies up to 78 % of a limit from it."""
ROUNDING = 1e-9
"""A gradient of this size is rounding, in the units of the QP."""

STATUS = {
    "kOptimal": Status.SOLVED,
    "kInfeasible": Status.INFEASIBLE,
    "kUnboundedOrInfeasible": Status.INFEASIBLE,  # H is positive definite, so not unbounded
    "kUnbounded": Status.NOT_CONVERGED,
    "kIterationLimit": Status.NOT_CONVERGED,
    "kTimeLimit": Status.NOT_CONVERGED,
    "kSolveError": Status.NOT_CONVERGED,
    **dict.fromkeys(
        (
            *("kNotset", "kLoadError", "kModelError", "kPresolveError", "kPostsolveError", "kModelEmpty"),
            *("kObjectiveBound", "kObjectiveTarget", "kSolutionLimit", "kMemoryLimit", "kUnknown"),
            *("kInterrupt", "kHighsInterrupt"),
        ),
        Status.NOT_CONVERGED,
    ),
}


@cache
def silent_binding() -> Any:
    """The module ``highspy``, its banner written.

    Since 1.16 a process's first object writes two lines to stdout before any option can be set. That is where
    a command writes its table, so these lines go nowhere.
    """
    import highspy

    try:
        stdout = os.dup(1)
    except OSError:  # closed: there is nowhere to write to
        highspy.Highs()  # type: ignore[no-untyped-call]  # its constructor alone has no types
        return highspy
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 1)
        highspy.Highs()  # type: ignore[no-untyped-call]  # as above
    finally:
        os.dup2(stdout, 1)
        os.close(stdout)
    return highspy


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Bounds become column bounds and A x = b row bounds; only these change."""
    highspy = silent_binding()
    from scipy.sparse import csc_matrix

    p, m = qp.A.shape
    C, d = qp.sides or (np.zeros((0, m)), np.zeros(0))
    stacked, below = np.vstack([qp.A, C]), np.full(len(d), -highspy.kHighsInf)
    lower, A = csc_matrix(np.tril(qp.H)), csc_matrix(stacked)
    problem = highspy.HighsModel()
    hessian, lp = problem.hessian_, problem.lp_
    hessian.dim_, hessian.start_, hessian.index_, hessian.value_ = m, lower.indptr, lower.indices, lower.data
    lp.num_col_, lp.num_row_ = m, p + len(d)
    lp.col_cost_ = qp.g
    matrix = lp.a_matrix_
    matrix.format_, matrix.num_row_, matrix.num_col_ = highspy.MatrixFormat.kColwise, p + len(d), m
    matrix.start_, matrix.index_, matrix.value_ = A.indptr, A.indices, A.data
    rows, columns = np.arange(p, dtype=np.int32), qp.bounded.astype(np.int32)
    low, high = qp.lb.copy(), qp.ub.copy()
    held = qp.lb[columns], qp.ub[columns]
    H = qp.H + SETTINGS[level].get("qp_regularization_value", REGULARIZATION) * np.eye(m)

    def borne_out(x: FloatArray, given: Any) -> bool:
        gradient = H.dot(x) + qp.g
        left = gradient - np.dot(given.row_dual, stacked) - given.col_dual
        return bool(np.abs(left).max() <= DENIED * np.abs(gradient).max() + ROUNDING)

    def set_up(b: FloatArray) -> Any:
        lp.row_lower_, lp.row_upper_ = np.concatenate([b, below]), np.concatenate([b, d])
        lp.col_lower_, lp.col_upper_ = low, high
        model = highspy.Highs()
        for key, value in SETTINGS[level].items():
            model.setOptionValue(key, value)
        model.passModel(problem)
        return model

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        low[columns], high[columns] = lb, ub
        return _solve(set_up(b), borne_out)

    def reused(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        nonlocal held
        model.clearSolver()  # forgets the last basis and solution
        model.changeRowsBounds(p, rows, b, b)
        if lb is not held[0] or ub is not held[1]:
            model.changeColsBounds(len(columns), columns, lb, ub)
            held = lb, ub
        return _solve(model, borne_out)

    return cold if start == "cold" else partial(reused, set_up(np.zeros(p)))


def _solve(model: Any, borne_out: Callable[[FloatArray, Any], bool]) -> Answer:
    """The model's answer, optimal only where that is ``borne_out`` by its multipliers."""
    before = model.getRunTime()  # HiGHS's clock, and with it the cap, runs on from call to call
    model.setOptionValue("time_limit", before + TIME_LIMIT_S)
    if model.run().name == "kError":  # threads that another HiGHS of this process has started are not one
        model.resetGlobalScheduler(True)
        model.run()
    status = meaning(STATUS, model.getModelStatus().name, "highs")
    given = model.getSolution()
    x = np.array(given.col_value)
    if status == Status.SOLVED and not borne_out(x, given):
        disbelieved["highs: optimal, which its multipliers deny"] += 1
        status = Status.NOT_CONVERGED
    return Answer(x, status, model.getInfo().qp_iteration_count, model.getRunTime() - before)
