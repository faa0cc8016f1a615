"""ProxQP: proximal augmented Lagrangian, dense, in C++."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "proxsuite"
VERSION = "0.8.0"
ALGORITHM = "proximal augmented Lagrangian"
LICENCE = "BSD-2-Clause"
STARTS: tuple[Start, ...] = ("cold", "reused", "warm")

# ProxQP has no time cap, and its default caps (10 000 outer iterations of 1 500 inner ones) let a stalled
# solve run for 17 s. The caps here are ten times what any healthy solve needs.
_CAPPED = {"compute_timings": True, "max_iter": 200, "max_iter_in": 100}
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _CAPPED,
    "tight": _CAPPED
    | {
        "eps_abs": 1e-10,  # ProxQP stops at residuals, and x may be 100 times further away
        "eps_primal_inf": 1e-6,  # the default 1e-4 lets 3 % of infeasible demands run into the caps
    },
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 0.2, "tight": 2e-6},
    "soft": {"default": 0.2, "tight": 1e-6},
}

# Its AVX code adds in an order that depends on where its memory lies, which differs from process to process;
# where it finds no answer, the last bits decide whether it ends at the cap or says infeasible.
ERRATIC = True

INFINITE = 1e20
"""ProxQP's number for no limit."""

STATUS = {
    "PROXQP_SOLVED": Status.SOLVED,
    "PROXQP_SOLVED_CLOSEST_PRIMAL_FEASIBLE": Status.INFEASIBLE,  # the answer is that of a shifted problem
    "PROXQP_PRIMAL_INFEASIBLE": Status.INFEASIBLE,
    "PROXQP_DUAL_INFEASIBLE": Status.NOT_CONVERGED,  # impossible with a positive definite H
    "PROXQP_MAX_ITER_REACHED": Status.NOT_CONVERGED,
    "PROXQP_NOT_RUN": Status.NOT_CONVERGED,
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Bounds become rows lb <= I x <= ub: ProxQP's box is no faster here, and takes no first guess.

    The warm start hands over the last solved x, y and z. ProxQP's WARM_START_WITH_PREVIOUS_RESULT would
    also keep the step sizes and the factors of the last solve: ProxQP 0.8.0 then calls feasible demands
    infeasible, or hangs, or crashes (docs/solvers.md).
    """
    from proxsuite import proxqp

    p, m = qp.A.shape
    bounded = qp.bounded
    rows, low, high = qp.two_sided, qp.lb[bounded], qp.ub[bounded]
    d = np.zeros(0) if qp.sides is None else qp.sides[1]
    below = np.full(len(d), -INFINITE)

    def with_sides(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        return (np.concatenate([low, below]), np.concatenate([high, d])) if len(d) else (low, high)

    def set_up(b: FloatArray) -> Any:
        model = proxqp.dense.QP(m, p, len(rows))
        for key, value in SETTINGS[level].items():
            setattr(model.settings, key, value)
        model.init(qp.H, qp.g, qp.A, b, rows, *with_sides(low, high))
        return model

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        nonlocal low, high
        low, high = lb, ub
        model = set_up(b)
        model.solve()
        return _result(model)

    if start == "cold":
        return cold
    model = set_up(np.zeros(p))
    guess = np.zeros(m), np.zeros(p), np.zeros(len(rows))

    def put(b: FloatArray, lb: FloatArray, ub: FloatArray) -> None:
        nonlocal low, high
        if lb is low and ub is high:
            model.update(b=b)
        else:
            lower, upper = with_sides(lb, ub)
            model.update(b=b, l=lower, u=upper)
            low, high = lb, ub

    def reused(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        put(b, lb, ub)
        model.solve()
        return _result(model)

    def warm(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        nonlocal guess
        put(b, lb, ub)
        model.solve(*guess)
        result = _result(model)
        if result.status == Status.INFEASIBLE:
            # With a guess this verdict is wrong for one demand in 200; without, it was never seen wrong.
            model.settings.initial_guess = proxqp.InitialGuess.EQUALITY_CONSTRAINED_INITIAL_GUESS
            model.solve()
            model.settings.initial_guess = proxqp.InitialGuess.WARM_START
            result = _result(model, result)
        if result.status == Status.SOLVED:
            guess = result.x, model.results.y.copy(), model.results.z.copy()
        return result

    if start == "warm":
        model.settings.initial_guess = proxqp.InitialGuess.WARM_START
        return warm
    return reused


def _result(model: Any, before: Answer | None = None) -> Answer:
    info = model.results.info
    status = meaning(STATUS, info.status.name, "proxqp")
    iterations, seconds = (before.iterations, before.solver_s) if before else (0, 0.0)
    seconds += info.run_time * 1e-6  # run_time is in us
    return Answer(model.results.x.copy(), status, iterations + info.iter, seconds)
