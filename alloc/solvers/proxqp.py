"""ProxQP: proximal augmented Lagrangian, dense, in C++."""

from functools import partial
from typing import Any

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES, PACKAGE = "proxsuite", "proxsuite"
ALGORITHM = "proximal augmented Lagrangian"
LICENCE = "BSD-2-Clause"
STARTS: tuple[Start, ...] = ("cold", "reused", "warm")

_CAPPED = {
    "compute_timings": True,
    "max_iter": 10_000,  # its own, written down; it has no time cap
}
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _CAPPED,
    "tight": _CAPPED | {"eps_abs": 1e-10},
}
TOLERANCE: dict[Level, float] = {"default": 1e-3, "tight": 1e-6}

STATUS = {
    "PROXQP_SOLVED": Status.SOLVED,
    "PROXQP_SOLVED_CLOSEST_PRIMAL_FEASIBLE": Status.INFEASIBLE,  # of a shifted problem
    "PROXQP_PRIMAL_INFEASIBLE": Status.INFEASIBLE,
    "PROXQP_DUAL_INFEASIBLE": Status.NOT_CONVERGED,  # impossible with a positive definite H
    "PROXQP_MAX_ITER_REACHED": Status.NOT_CONVERGED,
    "PROXQP_NOT_RUN": Status.NOT_CONVERGED,
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Bounds are box constraints of their own; only b is updated."""
    from proxsuite import proxqp

    p, m = qp.A.shape
    guess = proxqp.InitialGuess

    def set_up(b: FloatArray) -> Any:
        model = proxqp.dense.QP(m, p, 0, True)
        for key, value in SETTINGS[level].items():
            setattr(model.settings, key, value)
        model.init(qp.H, qp.g, qp.A, b, None, None, None, qp.lb, qp.ub)
        return model

    def cold(b: FloatArray) -> Answer:
        return _solve(set_up(b))

    def live(model: Any, b: FloatArray) -> Answer:
        model.update(b=b)
        return _solve(model)

    if start == "cold":
        return cold
    model = set_up(qp.A.sum(axis=1) * 0.0)
    if start == "warm":
        # The setting must not be in force before there is a result to start from: ProxQP 0.8.0
        # then hangs or crashes (docs/solvers.md). So one solve comes first.
        model.solve()
        model.settings.initial_guess = guess.WARM_START_WITH_PREVIOUS_RESULT
    return partial(live, model)


def _solve(model: Any) -> Answer:
    model.solve()
    info = model.results.info
    status = meaning(STATUS, info.status.name, "proxqp")
    return Answer(model.results.x, status, info.iter, info.run_time * 1e-6)
