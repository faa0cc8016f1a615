"""ECOS: interior point for second-order cone programs, in C; a QP has to be turned into one."""

from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.qp import QP
from alloc.qp.problem import OneSided
from alloc.solvers import Answer, Level, Solve, Start, meaning

REQUIRES = PACKAGE = "ecos"
VERSION = "2.0.14"
ALGORITHM = "interior point for second-order cones"
LICENCE = "GPL-3.0-or-later"
SHARED = 0.0  # smaller units lose 2 % of its answers where weights are 1e8 apart
STARTS: tuple[Start, ...] = ("cold",)  # ECOS's binding is one function: set-up and solve

# The iteration cap is ECOS's default, written down; it has no time cap. Where its steps stall, ECOS calls an
# answer "close" up to the *_inacc settings: 5e-5 as shipped, here 1e-8, which it ships as converged.
_INACCURATE = ("feastol_inacc", "abstol_inacc", "reltol_inacc")
_QUIET = {"verbose": False, "max_iters": 100} | dict.fromkeys(_INACCURATE, 1e-8)
SETTINGS: dict[Level, dict[str, Any]] = {
    "default": _QUIET,
    # A gap of g in |L'x| leaves x up to sqrt(2 g |L'x|) from the optimum where H = I. One solve in some
    # thousand stalls between 1e-10 and 1e-11, more where weights are far apart, and rounding decides which.
    "tight": _QUIET | dict.fromkeys(("abstol", "reltol"), 1e-11) | dict.fromkeys(_INACCURATE, 1e-9),
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
    """Pose min t s.t. |L'x + L^-1 g| <= t with H = L L', which has the minimiser of 1/2 x'Hx + g'x.

    The length itself makes a cone. Its square would make the cone |(L'x, t - 1/2)| <= t + 1/2, whose sides
    agree in most digits where the cost is large. L is measured in unit of its largest singular value.
    """
    import ecos
    from scipy.sparse import csc_matrix

    p, m = qp.A.shape
    L = np.linalg.cholesky(qp.H)
    unit = np.linalg.norm(L, 2)
    bounds = qp.one_sided[0]
    sides = OneSided(qp)
    cone = np.block([[np.zeros((1, m)), -np.ones((1, 1))], [-L.T / unit, np.zeros((m, 1))]])
    G = csc_matrix(np.vstack([np.column_stack([bounds, np.zeros(len(bounds))]), cone]))
    tail = np.concatenate([[0.0], np.linalg.solve(L, qp.g) / unit])
    dims = {"l": len(bounds), "q": [m + 1]}
    A = csc_matrix(np.column_stack([qp.A, np.zeros(p)]))
    c = np.append(np.zeros(m), 1.0)

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        sides.put(b, lb, ub)
        h = np.concatenate([sides.right[p:], tail])
        result = ecos.solve(c, G, h, dims, A, b.copy(), **SETTINGS[level])
        info = result["info"]
        status = meaning(STATUS, info["exitFlag"], "ecos")
        return Answer(result["x"][:m], status, info["iter"], info["timing"]["runtime"])

    return solve
