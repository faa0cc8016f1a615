"""CVXOPT: interior point for cone programs, in Python on BLAS and LAPACK."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "cvxopt"
VERSION = "1.3.3"
ALGORITHM = "interior point, in Python"
LICENCE = "GPL-3.0-or-later"
STARTS: tuple[Start, ...] = ("cold",)  # coneqp is a function; a guess would have to be interior

_QUIET = {"show_progress": False, "maxiters": 100}  # CVXOPT's default, written down; it has no time cap
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    # A gap of g leaves x up to sqrt(2 g) from the optimum: 1e-6 needs 1e-12.
    "tight": _QUIET | {"abstol": 1e-12, "reltol": 1e-12, "feastol": 1e-11},
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 2e-3, "tight": 1e-6},
    "soft": {"default": 0.05, "tight": 1e-6},
}

# CVXOPT says "unknown" of an infeasible QP too: coneqp has no certificate of infeasibility.
STATUS = {"optimal": Status.SOLVED, "unknown": Status.NOT_CONVERGED}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Finite bounds become rows G x <= h. The matrices are made once; only b and h change."""
    from cvxopt import matrix, solvers

    p = len(qp.A)
    fixed = [matrix(values) for values in (qp.H, qp.g, qp.one_sided[0])]
    A, sides = matrix(qp.A), OneSided(qp)

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        h = matrix(sides.right[p:])
        try:
            result = solvers.coneqp(*fixed, h, None, A, matrix(b), options=SETTINGS[level])
        except (ArithmeticError, ValueError):  # iterates of an infeasible problem overflow
            return Answer(qp.g, Status.NOT_CONVERGED)
        status = meaning(STATUS, result["status"], "cvxopt")
        return Answer(np.array(result["x"]).ravel(), status, result["iterations"])

    return solve
