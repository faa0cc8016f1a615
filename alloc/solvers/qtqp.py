"""QTQP: primal-dual interior point on the homogeneous embedding, in Python."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "qtqp"
VERSION = "0.0.7"
ALGORITHM = "interior point, in Python"
LICENCE = "Apache-2.0"
STARTS: tuple[Start, ...] = ("cold",)  # an object holds one b; milliseconds either way

SLOW = True  # 5 ms and more: it is written in Python

_QUIET = {"verbose": False, "max_iter": 100}  # its default cap, written down; it has no time cap
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    # A gap of g leaves x up to sqrt(2 g) from the optimum: 1e-6 needs 1e-12.
    "tight": _QUIET | {"tol_feas": 1e-10, "tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12},
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 1e-3, "tight": 1e-5},
    "soft": {"default": 1e-3, "tight": 1e-5},
}

STATUS = {
    "solved": Status.SOLVED,
    "infeasible": Status.INFEASIBLE,
    "unbounded": Status.NOT_CONVERGED,  # impossible with a positive definite H
    "hit_max_iter": Status.NOT_CONVERGED,
    "almost_solved": Status.NOT_CONVERGED,
    "failed": Status.NOT_CONVERGED,
    "unfinished": Status.NOT_CONVERGED,
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Equations first, then the finite bounds: [A; G] x + s = [b; h]."""
    import qtqp
    from scipy.sparse import csc_matrix

    p = len(qp.A)
    sides = OneSided(qp)
    P, A = csc_matrix(qp.H), csc_matrix(np.vstack([qp.A, qp.one_sided[0]]))

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        model = qtqp.QTQP(p=P, a=A, b=sides.right.copy(), c=qp.g, z=p)
        with np.errstate(all="ignore"):  # iterates of a demand far too large overflow
            solution = model.solve(**SETTINGS[level])
        status = meaning(STATUS, solution.status.value, "qtqp")
        return Answer(np.array(solution.x), status, solution.iterations)

    return solve
