"""SCS: operator splitting (ADMM) on the homogeneous embedding, first order, in C."""

from functools import partial
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "scs"
VERSION = "3.3.1"
ALGORITHM = "operator splitting (ADMM), homogeneous embedding"
LICENCE = "MIT"
# Not "reused": an object keeps its Anderson memory and the sums from which it adapts its step size, nothing
# sets them back, and one demand in 200 on odd vehicles then has another status after other calls.
STARTS: tuple[Start, ...] = ("cold", "warm")

# Left to itself SCS takes Intel's MKL where that can be loaded, twice as slow for matrices this small.
_QUIET = {"verbose": False, "time_limit_secs": TIME_LIMIT_S, "linear_solver": "qdldl"}
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET | {"max_iters": 100_000},  # SCS's default, written down
    # SCS stops at residuals, and x may be 100 times further from the optimum. It has no polishing.
    "tight": _QUIET | {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20_000},
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 0.02, "tight": 1e-6},
    "soft": {"default": 0.1, "tight": 1e-5},
}

STATUS = {
    1: Status.SOLVED,
    2: Status.NOT_CONVERGED,  # solved inaccurate
    -1: Status.NOT_CONVERGED,  # unbounded: impossible with a positive definite H
    -2: Status.INFEASIBLE,
    -3: Status.NOT_CONVERGED,  # indeterminate
    -4: Status.NOT_CONVERGED,  # failed
    -5: Status.NOT_CONVERGED,  # an interrupt
    -6: Status.NOT_CONVERGED,  # unbounded inaccurate
    -7: Status.NOT_CONVERGED,  # infeasible inaccurate
    0: Status.NOT_CONVERGED,  # unfinished
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Equalities become a zero cone, finite bounds a nonnegative one: [A; G] x + s = [b; h]."""
    import scs
    from scipy.sparse import csc_matrix

    p = len(qp.A)
    G, h = qp.one_sided
    sides = OneSided(qp)
    right = sides.right
    data = {"P": csc_matrix(np.triu(qp.H)), "A": csc_matrix(np.vstack([qp.A, G])), "b": right, "c": qp.g}
    cone = {"z": p, "l": len(h)}

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        return _answer(scs.SCS(data, cone, **SETTINGS[level]).solve(warm_start=False))

    def warm(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        model.update(b=right)
        return _answer(model.solve(warm_start=True))

    return cold if start == "cold" else partial(warm, scs.SCS(data, cone, **SETTINGS[level]))


def _answer(result: Any) -> Answer:
    info = result["info"]
    status = meaning(STATUS, info["status_val"], "scs")
    return Answer(result["x"], status, info["iter"], info["solve_time"] * 1e-3)  # solve_time is in ms
