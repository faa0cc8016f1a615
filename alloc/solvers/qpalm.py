"""QPALM: proximal augmented Lagrangian with semismooth Newton steps, in C."""

from functools import partial
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import TwoSided
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "qpalm"
VERSION = "1.3.0"
ALGORITHM = "proximal augmented Lagrangian, semismooth Newton"
LICENCE = "LGPL-3.0-or-later"
STARTS: tuple[Start, ...] = ("cold", "reused", "warm")

_QUIET = {"verbose": False, "max_iter": 10_000, "time_limit": TIME_LIMIT_S}
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    # At 1e-10 a reused object now and then uses up its iterations and fails.
    "tight": _QUIET | {"eps_abs": 1e-8, "eps_rel": 1e-8},
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 0.02, "tight": 4e-5},
    "soft": {"default": 0.02, "tight": 2e-5},
}

SHARED = 0.0  # QPALM scales the problem by itself, and better than smaller units would

STATUS = {
    1: Status.SOLVED,
    2: Status.NOT_CONVERGED,  # dual terminated
    -2: Status.NOT_CONVERGED,  # iteration cap
    -3: Status.INFEASIBLE,
    -4: Status.NOT_CONVERGED,  # dual infeasible: impossible with a positive definite H
    -5: Status.NOT_CONVERGED,  # time cap
    -6: Status.NOT_CONVERGED,  # cancelled
    -10: Status.NOT_CONVERGED,  # unsolved
    0: Status.NOT_CONVERGED,  # error
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Bounds become rows: bmin <= [A; I] x <= bmax, with the rows of I that bound something."""
    import qpalm
    from scipy.sparse import csc_matrix

    m = len(qp.g)
    sides = TwoSided(qp)
    data = qpalm.Data(m, len(sides.low))
    data.Q, data.q = csc_matrix(qp.H), qp.g
    data.A = csc_matrix(np.vstack([qp.A, qp.two_sided]))
    settings = qpalm.Settings()
    for key, value in SETTINGS[level].items():
        setattr(settings, key, value)

    def set_up() -> Any:
        data.bmin, data.bmax = sides.low, sides.high
        return qpalm.Solver(data, settings)

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        return _solve(set_up())

    def reused(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        model.update_bounds(sides.low, sides.high)
        return _solve(model)

    def warm(model: Any, b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        if model.info.status == "solved":
            model.warm_start(model.solution.x, model.solution.y)
        return reused(model, b, lb, ub)

    if start == "cold":
        return cold
    return partial(warm if start == "warm" else reused, set_up())


def _solve(model: Any) -> Answer:
    model.solve(asynchronous=False)  # True starts a thread for each call, to hear Ctrl-C
    info = model.info
    status = meaning(STATUS, info.status_val, "qpalm")
    return Answer(np.array(model.solution.x), status, info.iter, info.run_time)
