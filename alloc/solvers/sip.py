"""SIP: interior point with a line search on a barrier and a penalty, in C++, from its QP front-end."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.solvers import TIME_LIMIT_S, Answer, Level, Solve, Start, meaning

REQUIRES, PACKAGE = "sip_qp_python", "sip-qp-python"
VERSION = "0.0.2"
ALGORITHM = "interior point, augmented barrier and Lagrangian"
LICENCE = "MIT"
STARTS: tuple[Start, ...] = ("cold",)  # an object holds one b; a guess of x alone saves no iterations

SLOW = True  # 8 ms where a demand is infeasible, which its line search does not find out

_CAPPED = {"sip.max_iterations": 1000}  # its default, written down
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _CAPPED,
    # A gap of g leaves x up to sqrt(2 g) from the optimum: 1e-6 needs 1e-12.
    "tight": _CAPPED
    | {
        "termination.max_absolute_residual": 1e-10,
        "termination.max_absolute_duality_gap": 1e-12,
        "termination.max_relative_duality_gap": 1e-12,
    },
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 1e-4, "tight": 1e-6},
    "soft": {"default": 1e-4, "tight": 1e-6},
}

STATUS = {
    "SOLVED": Status.SOLVED,
    "SUBOPTIMAL": Status.NOT_CONVERGED,
    "LOCALLY_INFEASIBLE": Status.INFEASIBLE,
    "ITERATION_LIMIT": Status.NOT_CONVERGED,
    "LINE_SEARCH_ITERATION_LIMIT": Status.NOT_CONVERGED,  # the usual end of an infeasible demand
    "LINE_SEARCH_FAILURE": Status.NOT_CONVERGED,
    "TIMEOUT": Status.NOT_CONVERGED,
    "FAILED_CHECK": Status.NOT_CONVERGED,
    "FACTORIZATION_FAILURE": Status.NOT_CONVERGED,
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """The standard form is SIP's own, without rows G; each call needs a new object."""
    import sip_qp_python as sip
    from scipy.sparse import csc_matrix, csr_matrix

    qp.refuse_sides("sip")
    m = len(qp.g)
    settings = sip.Settings()
    for path, value in SETTINGS[level].items():
        group, _, key = path.partition(".")
        setattr(getattr(settings, group), key, value)
    P, no_rows, none = csc_matrix(qp.H), csr_matrix((0, m)), np.zeros(0)
    bounded, guess, eye = qp.bounded, np.zeros(m), np.eye(m)
    low, high = qp.lb.copy(), qp.ub.copy()

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        low[bounded], high[bounded] = lb, ub
        still = low == high  # SIP refuses a variable without room: an equation says as much
        A, right = csr_matrix(np.vstack([qp.A, eye[still]])), np.concatenate([b, low[still]])
        low[still], high[still] = -np.inf, np.inf
        order = np.arange(m + len(right), dtype=np.int32)
        model = sip.Solver(P, qp.g, no_rows, none, A, right, low, high, order, settings, TIME_LIMIT_S)
        result = model.solve(guess)
        status = meaning(STATUS, result.info.exit_status.name, "sip")
        return Answer(np.array(result.x), status, result.info.num_iterations)

    return solve
