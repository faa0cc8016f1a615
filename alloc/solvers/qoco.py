"""QOCO: primal-dual interior point for second-order cones, in C; the library, not what QOCOGEN writes."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "qoco"
VERSION = "0.3.2"
ALGORITHM = "primal-dual interior point"
LICENCE = "BSD-3-Clause"
STARTS: tuple[Start, ...] = ("cold", "reused")  # QOCO takes no first guess

_QUIET = {"verbose": 0, "max_iters": 200}  # QOCO's defaults, written down; it has no time cap
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    # A gap of g leaves x up to sqrt(2 g) from the optimum: 1e-6 needs 1e-12. 1e-13 fails twice as often.
    "tight": _QUIET | dict.fromkeys(("abstol", "reltol"), 1e-12),
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 5e-4, "tight": 3e-6},  # 1.2e-6 on random vehicles, at a limit without a multiplier
    "soft": {"default": 5e-4, "tight": 5e-7},
}

STATUS = {
    "QOCO_UNSOLVED": Status.NOT_CONVERGED,
    "QOCO_SOLVED": Status.SOLVED,
    "QOCO_SOLVED_INACCURATE": Status.NOT_CONVERGED,  # stalled within 1e-5
    "QOCO_NUMERICAL_ERROR": Status.NOT_CONVERGED,  # also where a demand is infeasible: it proves nothing
    "QOCO_MAX_ITER": Status.NOT_CONVERGED,
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Equations A x = b, finite bounds as G x <= h."""
    import qoco
    from scipy.sparse import csc_matrix

    p, m = qp.A.shape
    bounds, h = qp.one_sided
    P, A, G = csc_matrix(qp.H), csc_matrix(qp.A) if p else None, csc_matrix(bounds)  # QOCO takes no empty A
    sides = OneSided(qp)

    def set_up() -> Any:
        model, right = qoco.QOCO(), sides.right
        b = right[:p] if p else None
        model.setup(m, len(h), p, P, qp.g, A, b, G, right[p:], len(h), 0, None, **SETTINGS[level])
        return model

    def cold(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        return _solve(set_up())

    kept = set_up()

    def reused(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        nonlocal kept
        sides.put(b, lb, ub)
        kept.update_vector_data(b=sides.right[:p] if p else None, h=sides.right[p:])
        answer = _solve(kept)
        if answer.status is not Status.SOLVED:
            kept = set_up()  # what stalled once fails on demands that a new object solves
        return answer

    return cold if start == "cold" else reused


def _solve(model: Any) -> Answer:
    result = model.solve()
    status = meaning(STATUS, result.status, "qoco")
    return Answer(np.array(result.x), status, result.iters, result.solve_time_sec)
