"""ECOS: interior point for second-order cone programs, in C; a QP has to be turned into one."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.sides import OneSided
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "ecos"
ALGORITHM = "interior point for second-order cones"
LICENCE = "GPL-3.0-or-later"
STARTS: tuple[Start, ...] = ("cold",)  # ECOS's binding is one function: set-up and solve

# The iteration cap is ECOS's default, written down; it has no time cap. Where its steps stall, ECOS calls an
# answer "close" up to the *_inacc settings: 5e-5 as shipped, here 1e-8, which it ships as converged.
_QUIET = {"verbose": False, "max_iters": 100} | dict.fromkeys(
    ("feastol_inacc", "abstol_inacc", "reltol_inacc"), 1e-8
)
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    # A gap of g leaves x up to sqrt(2 g) from the optimum. About one solve in a thousand stalls from 1e-10 to
    # 1e-11, and the processor's rounding decides which; from 1e-12 on one in ten stalls.
    "tight": _QUIET | {"abstol": 1e-11, "abstol_inacc": 1e-10, "reltol": 1e-13, "reltol_inacc": 1e-13},
}
TOLERANCE: dict[str, dict[Level, float]] = {
    "hard": {"default": 2e-4, "tight": 2e-5},
    "soft": {"default": 5e-3, "tight": 6e-4},
}

STATUS = {
    0: Status.SOLVED,
    1: Status.INFEASIBLE,
    2: Status.NOT_CONVERGED,  # dual infeasible: impossible with a positive definite H
    10: Status.SOLVED,  # close to optimal: as close as SETTINGS say
    11: Status.NOT_CONVERGED,  # close to infeasible
    12: Status.NOT_CONVERGED,
    -1: Status.NOT_CONVERGED,  # iteration cap
    -2: Status.NOT_CONVERGED,  # numerical trouble
    -3: Status.NOT_CONVERGED,  # left the cone
    -7: Status.NOT_CONVERGED,  # unknown problem
}


def prepare(qp: QP, start: Start, level: Level) -> Solve:
    """Pose min t + g'x s.t. 1/2 |L'x|^2 <= t with H = L L'.

    The constraint is a second-order cone, |(L'x, t - 1/2)| <= t + 1/2.
    """
    import ecos
    from scipy.sparse import csc_matrix

    p, m = qp.A.shape
    zero = np.zeros(m)
    last = np.vstack([[*zero, -1.0], np.column_stack([-np.linalg.cholesky(qp.H).T, zero]), [*zero, -1.0]])
    bounds = qp.one_sided[0]
    sides = OneSided(qp)
    G = csc_matrix(np.vstack([np.column_stack([bounds, np.zeros(len(bounds))]), last]))
    tail = np.array([0.5, *zero, -0.5])
    dims = {"l": len(bounds), "q": [m + 2]}
    A = csc_matrix(np.column_stack([qp.A, np.zeros(p)]))
    c = np.append(qp.g, 1.0)

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        h = np.concatenate([sides.right[p:], tail])
        result = ecos.solve(c, G, h, dims, A, b.copy(), **SETTINGS[level])
        info = result["info"]
        status = meaning(STATUS, info["exitFlag"], "ecos")
        return Answer(result["x"][:m], status, info["iter"], info["timing"]["runtime"])

    return solve
