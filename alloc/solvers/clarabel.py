"""Clarabel: interior point on the homogeneous embedding, in Rust."""

from functools import partial
from math import nan
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "clarabel"
VERSION = "0.11.1"
ALGORITHM = "interior point, homogeneous embedding"
LICENCE = "Apache-2.0"
STARTS: tuple[Start, ...] = ("cold", "reused")  # Clarabel takes no first guess

_QUIET = {
    "verbose": False,
    "time_limit": TIME_LIMIT_S,
    "max_iter": 200,  # Clarabel's default, written down
    "max_threads": 1,  # one core is measured
    "presolve_enable": False,  # a presolved problem can't be updated, and there is nothing to presolve
}
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    # A gap of g leaves x up to sqrt(2 g) from the optimum: 1e-6 needs 1e-12, near what doubles can show.
    "tight": _QUIET | {"tol_gap_abs": 1e-13, "tol_gap_rel": 1e-13, "tol_feas": 1e-11},
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 1e-4, "tight": 1e-6},
    "soft": {"default": 2e-3, "tight": 1e-6},
}

STATUS = {
    "Solved": Status.SOLVED,
    "AlmostSolved": Status.NOT_CONVERGED,
    "PrimalInfeasible": Status.INFEASIBLE,
    "AlmostPrimalInfeasible": Status.NOT_CONVERGED,
    "DualInfeasible": Status.NOT_CONVERGED,  # impossible with a positive definite H
    "AlmostDualInfeasible": Status.NOT_CONVERGED,
    "MaxIterations": Status.NOT_CONVERGED,
    "MaxTime": Status.NOT_CONVERGED,
    "NumericalError": Status.NOT_CONVERGED,
    "InsufficientProgress": Status.NOT_CONVERGED,
    "CallbackTerminated": Status.NOT_CONVERGED,
    "Unsolved": Status.NOT_CONVERGED,
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Equalities become a zero cone, finite bounds a nonnegative one: [A; G] x + s = [b; h]."""
    import clarabel
    from scipy.sparse import csc_matrix

    p = len(qp.A)
    G, h = qp.one_sided
    P, A = csc_matrix(np.triu(qp.H)), csc_matrix(np.vstack([qp.A, G]))
    sides = OneSided(qp)
    right = sides.right
    cones = [clarabel.ZeroConeT(p), clarabel.NonnegativeConeT(len(h))]
    settings = clarabel.DefaultSettings()
    for key, value in SETTINGS[level].items():
        setattr(settings, key, value)

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        return _solve(clarabel.DefaultSolver(P, qp.g, A, right, cones, settings))

    def reused(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        model.update(b=right)
        # Clarabel's clock adds the one set-up to every solve, so it does not time this call.
        return _solve(model)._replace(solver_s=nan)

    if start == "cold":
        return cold
    return partial(reused, clarabel.DefaultSolver(P, qp.g, A, right, cones, settings))


def _solve(model: Any) -> Answer:
    solution = model.solve()
    status = meaning(STATUS, str(solution.status), "clarabel")
    return Answer(np.array(solution.x), status, solution.iterations, solution.solve_time)
