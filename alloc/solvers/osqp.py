"""OSQP: operator splitting (ADMM), first order; x ends near a face, and polishing may put it there."""

from functools import partial
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import TwoSided
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "osqp"
VERSION = "1.1.3"
ALGORITHM = "operator splitting (ADMM)"
LICENCE = "Apache-2.0"
STARTS: tuple[Start, ...] = ("cold", "reused", "warm")

_QUIET = {"verbose": False, "time_limit": TIME_LIMIT_S}
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET | {"max_iter": 4000},  # OSQP's default, written down
    "tight": _QUIET
    | {
        # OSQP stops at residuals, and x may be 100 times further from the optimum.
        "eps_abs": 1e-8,
        "eps_rel": 1e-8,
        "max_iter": 20_000,  # ten times the accuracy costs several times the iterations
        "polishing": True,  # one solve on the guessed active set: exact where the guess is right
    },
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 0.1, "tight": 5e-6},
    "soft": {"default": 0.1, "tight": 5e-6},
}

SHARED = 0.0  # OSQP scales the problem by itself, and better than smaller units would

STATUS = {
    1: Status.SOLVED,
    2: Status.NOT_CONVERGED,  # solved inaccurate
    3: Status.INFEASIBLE,
    4: Status.NOT_CONVERGED,  # primal infeasible inaccurate
    5: Status.NOT_CONVERGED,  # dual infeasible: impossible with a positive definite H
    6: Status.NOT_CONVERGED,
    7: Status.NOT_CONVERGED,  # iteration cap
    8: Status.NOT_CONVERGED,  # time cap
    9: Status.NOT_CONVERGED,  # not convex: impossible too
    10: Status.NOT_CONVERGED,  # an interrupt
    11: Status.NOT_CONVERGED,  # unsolved
}


RHO = 0.1
"""OSQP's step size as shipped. An infeasible demand drives it far away, where the next solve fails."""


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Bounds become rows: l <= [A; I] x <= u, with the rows of I that bound something."""
    import osqp

    sides = TwoSided(qp)
    posed = problem(qp) | {"l": sides.low, "u": sides.high}
    # Without warm_starting each solve begins at zero, but rho stays what the last solve made of it.
    settings = SETTINGS[level] | {"warm_starting": start == "warm"}

    def set_up() -> Any:
        model = osqp.OSQP()
        model.setup(**posed, **settings)
        return model

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        return _answer(set_up().solve(raise_error=False))

    def warm(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        model.update(l=sides.low, u=sides.high)
        return _answer(model.solve(raise_error=False))

    def reused(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        model.update(l=sides.low, u=sides.high)
        result = model.solve(raise_error=False)
        answer = _answer(result)
        if result.info.rho_updates:
            model.update_settings(rho=RHO)
        return answer

    if start == "cold":
        return cold
    return partial(warm if start == "warm" else reused, set_up())


def problem(qp: QP) -> dict[str, Any]:
    """Arguments of OSQP's setup: rows [A; I], l = u = 0 in those of A, the problem's bounds in those of I."""
    from scipy.sparse import csc_matrix, vstack

    sides = TwoSided(qp)
    rows = vstack([csc_matrix(qp.A), csc_matrix(qp.two_sided)], format="csc")
    return {"P": csc_matrix(np.triu(qp.H)), "q": qp.g, "A": rows, "l": sides.low, "u": sides.high}


def _answer(result: Any) -> Answer:
    info = result.info
    status = meaning(STATUS, info.status_val, "osqp")
    return Answer(result.x, status, info.iter, info.run_time)
